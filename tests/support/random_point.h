// Random points.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/rng.h"

namespace vdbpack::test {

template <int Dim>
Vec<Dim> randomPoint(RandomStream& random, const Box<Dim>& box) {
    Vec<Dim> x;
    for (int d = 0; d < Dim; ++d) x[d] = box.lo[d] + random.uniform() * (box.hi[d] - box.lo[d]);
    return x;
}

/// A point in the cube from -extent to extent.
inline Vec<3> randomPoint(RandomStream& random, double extent) {
    Vec<3> p;
    for (int d = 0; d < 3; ++d) p[d] = (2 * random.uniform() - 1) * extent;
    return p;
}

}  // namespace vdbpack::test
