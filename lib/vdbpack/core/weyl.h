// Points spread evenly over a box.
#pragma once

#include "vdbpack/core/box.h"

#include <cmath>
#include <cstddef>

namespace vdbpack {

/// Point `n` of Weyl's sequence: spread evenly, without a lattice to resonate with the bone.
inline Vec<3> weylPoint(std::size_t n, const Box<3>& box) {
    constexpr double kWeyl[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    Vec<3> x;
    for (int d = 0; d < 3; ++d)
        x[d] = box.lo[d] +
               std::fmod((static_cast<double>(n) + 0.5) * kWeyl[d], 1.0) * (box.hi[d] - box.lo[d]);
    return x;
}

}  // namespace vdbpack
