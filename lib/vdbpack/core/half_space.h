// Sides of planes (2D: of lines), by which domains are clipped.
#pragma once

#include "vdbpack/core/vec.h"

namespace vdbpack {

/// The side n.x <= offset of a plane (2D: line); `normal` need not have length one.
template <int Dim>
struct HalfSpace {
    Vec<Dim> normal;
    double offset = 0;  ///< n.x on the plane
};

}  // namespace vdbpack
