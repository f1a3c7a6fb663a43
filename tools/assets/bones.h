// Four bones, sculpted from memory of anatomy: recognizable shapes, not anyone's anatomy.
#pragma once

#include "sculpture.h"

namespace vdbpack {

/// Coordinates as in CT (LPS): +x to the person's left, +y to the back, +z up; mm.
Sculpture femur();     ///< right thigh bone, 430 mm
Sculpture mandible();  ///< lower jaw with teeth, 118 mm wide
Sculpture hip();       ///< right hip bone (os coxae), 210 mm
Sculpture skull();     ///< cranium without lower jaw, its cavity open at the foramen magnum

}  // namespace vdbpack
