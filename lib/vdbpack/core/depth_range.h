// How far a point is from the wall, as far as is known.
#pragma once

#include <limits>

namespace vdbpack {

/// Bounds of the depth of a point, mm: its distance to the wall inside, the negative one outside.
struct DepthRange {
    double least = -std::numeric_limits<double>::infinity();
    double most = std::numeric_limits<double>::infinity();
};

}  // namespace vdbpack
