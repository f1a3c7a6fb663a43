// Random points.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/core/vec.h"

namespace vdbpack::test {

/// A point in the cube from -extent to extent.
inline Vec<3> randomPoint(RandomStream& random, double extent) {
    Vec<3> p;
    for (int d = 0; d < 3; ++d) p[d] = (2 * random.uniform() - 1) * extent;
    return p;
}

}  // namespace vdbpack::test
