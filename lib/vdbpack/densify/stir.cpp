#include "vdbpack/densify/stir.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"

#include <map>
#include <utility>

namespace vdbpack {

namespace {

/// Way that circles of nearly equal size are moved at random first, in radii along each axis.
constexpr double kStir = 0.8;
constexpr std::uint64_t kStirring = 0x7374697272696e67ull;
constexpr std::uint64_t kMixing = 0x6d6978696e67ull;

}  // namespace

template <int Dim>
void mixSizes(std::uint64_t seed, std::uint64_t stage, std::size_t fixed,
              const std::vector<std::int32_t>& regions, std::vector<Sphere<Dim>>& spheres,
              std::vector<std::uint32_t>& places) {
    std::map<std::int32_t, std::vector<std::uint32_t>> all;
    for (std::size_t i = fixed; i < places.size(); ++i)
        all[regions.empty() ? 0 : regions[i]].push_back(static_cast<std::uint32_t>(i));
    const std::vector<Sphere<Dim>> before = spheres;
    const std::vector<std::uint32_t> placesBefore = places;
    RandomStream random(seed ^ kMixing, stage);
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

template <int Dim>
void stir(std::uint64_t seed, const Domain<Dim>& domain, std::size_t fixed,
          const std::vector<std::uint32_t>& labels, std::vector<Sphere<Dim>>& spheres) {
    parallelFor(IndexRange(fixed, spheres.size(), 1024), [&](const IndexRange& part) {
        const auto sampler = domain.sampler();
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            RandomStream random(seed ^ kStirring, labels.empty() ? i : labels[i]);
            Sphere<Dim>& s = spheres[i];
            Vec<Dim> to = s.center;
            for (int d = 0; d < Dim; ++d) to[d] += kStir * s.radius * (2 * random.uniform() - 1);
            if (sampler->signedDistance(to) < -0.5 * s.radius) s.center = to;
        }
    });
}

#define VDBPACK_INSTANTIATE(Dim)                                                             \
    template void mixSizes<Dim>(std::uint64_t, std::uint64_t, std::size_t,                   \
                                const std::vector<std::int32_t>&, std::vector<Sphere<Dim>>&, \
                                std::vector<std::uint32_t>&);                                \
    template void stir<Dim>(std::uint64_t, const Domain<Dim>&, std::size_t,                  \
                            const std::vector<std::uint32_t>&, std::vector<Sphere<Dim>>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
