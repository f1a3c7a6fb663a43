// Private to densify: what a front leaves in order is put at random before spheres are relaxed.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace vdbpack {

/// Exchanges positions at random among the spheres of a region: DensifyOptions::mixSizes.
/// @param fixed    number of the first spheres, which stay where they are.
/// @param regions  of the spheres; empty: all are in one.
/// @param places   of the spheres; exchanged with their positions.
template <int Dim>
void mixSizes(std::uint64_t seed, std::uint64_t stage, std::size_t fixed,
              const std::vector<std::int32_t>& regions, std::vector<Sphere<Dim>>& spheres,
              std::vector<std::uint32_t>& places) {
    std::map<std::int32_t, std::vector<std::uint32_t>> all;
    for (std::size_t i = fixed; i < places.size(); ++i)
        all[regions.empty() ? 0 : regions[i]].push_back(static_cast<std::uint32_t>(i));
    const std::vector<Sphere<Dim>> before = spheres;
    const std::vector<std::uint32_t> placesBefore = places;
    RandomStream random(seed ^ 0x6d6978696e67ull, stage);
    for (const auto& [region, to] : all) {
        std::vector<std::uint32_t> from = to;
        for (std::size_t k = from.size(); k > 1; --k)
            std::swap(from[k - 1], from[random.bits() % k]);
        for (std::size_t k = 0; k < to.size(); ++k) {
            spheres[to[k]].center = before[from[k]].center;
            places[to[k]] = placesBefore[from[k]];
        }
    }
}

/// Moves spheres at random within the domain: before a front settles, and equal circles in rows.
/// @param fixed   number of the first spheres, which stay where they are.
/// @param labels  numbers of the spheres among those of all ranks; empty: their indices.
/// @param way     largest way along each axis, in radii.
template <int Dim>
void stir(std::uint64_t seed, const Domain<Dim>& domain, std::size_t fixed,
          const std::vector<std::uint32_t>& labels, std::vector<Sphere<Dim>>& spheres,
          double way = 0.8) {
    parallelFor(IndexRange(fixed, spheres.size(), 1024), [&](const IndexRange& part) {
        const auto sampler = domain.sampler();
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            RandomStream random(seed ^ 0x7374697272696e67ull, labels.empty() ? i : labels[i]);
            Sphere<Dim>& s = spheres[i];
            Vec<Dim> to = s.center;
            for (int d = 0; d < Dim; ++d) to[d] += way * s.radius * (2 * random.uniform() - 1);
            if (sampler->signedDistance(to) < -0.5 * s.radius) s.center = to;
        }
    });
}

}  // namespace vdbpack
