// The share of a volume that spheres have, the same digits in any order and over any ranks.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"

#include <tbb/parallel_reduce.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdbpack {

/// The volumes (2D: areas) of spheres, with radii greater by `shell`, divided by `volume`: the sum
/// of whole 2^-58 parts, less than 64. @param ranks  of whose spheres these are a share; null: all.
template <int Dim>
double ballShare(const std::vector<Sphere<Dim>>& spheres, double volume, Ranks* ranks = nullptr,
                 double shell = 0) {
    constexpr double kParts = 0x1p58;
    const double scale = kParts / volume;
    const std::uint64_t own = tbb::parallel_reduce(
        IndexRange(0, spheres.size(), 4096), std::uint64_t{0},
        [&](const IndexRange& part, std::uint64_t sum) {
            for (std::size_t i = part.begin(); i < part.end(); ++i)
                sum += static_cast<std::uint64_t>(Measure<Dim>::ball(spheres[i].radius + shell) *
                                                  scale);
            return sum;
        },
        std::plus<>());
    return static_cast<double>(sumOver(ranks, own)) / kParts;
}

}  // namespace vdbpack
