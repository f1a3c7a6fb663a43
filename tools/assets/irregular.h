// An irregular body with bumps and hollows.
#pragma once

#include "sculpture.h"

namespace vdbpack {

/// A lumpy ball about 60 mm across, with a bite and two pits; mm, about the origin.
Sculpture irregular();

}  // namespace vdbpack
