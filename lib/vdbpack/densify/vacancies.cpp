// Vacancies: points with much room for further spheres.
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <limits>
#include <map>

namespace vdbpack {

namespace {

/// Points drawn for each vacancy.
constexpr int kDraws = 30;

/// The smallest distance from a point to the surfaces of `bodies` (whole eights), quanta.
float room(const std::vector<Body>& bodies, const Body& at) {
    Float8 least = Float8{} + std::numeric_limits<float>::max();
    for (std::size_t j = 0; j < bodies.size(); j += 8) {
        const Bodies8 other = load(bodies.data() + j);
        const Float8 dx = difference(other.x, at.x);
        const Float8 dy = difference(other.y, at.y);
        const Float8 dz = difference(other.z, at.z);
        least = smaller(least, squareRoot(dx * dx + dy * dy + dz * dz) - other.radius);
    }
    return smallest(least);
}

}  // namespace

template <int Dim>
std::vector<Sphere<Dim>> Relaxation<Dim>::vacancies(const std::vector<double>& radii,
                                                    const std::vector<std::int32_t>& regions,
                                                    std::uint64_t salt, const Belongs& belongs) {
    std::vector<Sphere<Dim>> placed(radii.size());
    if (!ready_ || radii.empty()) return placed;
    if (cell_.any()) {  // with images as far as vacancies are sought
        further_ = static_cast<float>(*std::max_element(radii.begin(), radii.end()) / quantum_);
        sort();
    }
    // The slots of each region in the order of the cells, and how many spheres are added to it.
    struct Region {
        std::vector<std::uint32_t> slots;
        std::size_t added = 0;
    };
    std::map<std::int32_t, Region> all;
    const bool many = !regions.empty() && !regions_.empty();
    for (std::uint32_t slot = 0; slot < now_.labels.size(); ++slot)
        if (now_.labels[slot] != kOfOthers)
            all[many ? regions_[now_.labels[slot]] : 0].slots.push_back(slot);
    std::vector<std::size_t> numbers(radii.size());  // of each further sphere within its region
    for (std::size_t k = 0; k < radii.size(); ++k) numbers[k] = all[many ? regions[k] : 0].added++;
    parallelFor(IndexRange(0, radii.size(), 64), [&](const IndexRange& part) {
        std::vector<Body> around;
        for (std::size_t k = part.begin(); k < part.end(); ++k) {
            RandomStream random(seed_ ^ mix64(salt), k);
            // Anchors at equal distances in the order of the cells: evenly spread over the spheres.
            const Region& region = all.at(many ? regions[k] : 0);
            const auto anchor = static_cast<std::size_t>(
                (static_cast<double>(numbers[k]) + random.uniform()) /
                static_cast<double>(region.added) * static_cast<double>(region.slots.size()));
            std::function<bool(const Vec<Dim>&)> here;
            if (belongs) here = [&, k](const Vec<Dim>& x) { return belongs(x, regions[k]); };
            placed[k] = {
                vacancyNear(region.slots[anchor], radii[k] / quantum_, random, around, here),
                radii[k]};
        }
    });
    return placed;
}

template <int Dim>
std::vector<typename Relaxation<Dim>::Vacancy> Relaxation<Dim>::vacanciesHere(
    const std::vector<double>& radii, std::uint64_t salt) {
    std::vector<Vacancy> found;
    if (!ready_) return found;
    std::uint64_t own = 0;
    for (const std::uint8_t near : isNearSlot_) own += near == 0;
    const auto slots = static_cast<double>(sumOver(ranks_, own));
    std::vector<Body> around;
    for (std::size_t k = 0; k < radii.size(); ++k) {
        RandomStream random(seed_ ^ mix64(salt), k);
        const auto anchor = static_cast<std::uint32_t>((static_cast<double>(k) + random.uniform()) /
                                                       static_cast<double>(radii.size()) * slots);
        const auto at = std::lower_bound(slots_.begin(), slots_.end(), anchor);
        if (at == slots_.end() || *at != anchor) continue;
        const auto slot = static_cast<std::uint32_t>(at - slots_.begin());
        if (isNearSlot_[slot]) continue;
        found.push_back({k, vacancyNear(slot, radii[k] / quantum_, random, around)});
    }
    return found;
}

template <int Dim>
Vec<Dim> Relaxation<Dim>::vacancyNear(std::uint32_t slot, double radius, RandomStream& random,
                                      std::vector<Body>& around,
                                      const std::function<bool(const Vec<Dim>&)>& belongs) {
    DomainSampler<Dim>& sampler = walls_.sampler();
    const Home& home = now_.homes[slot];
    const double half = static_cast<double>(now_.bodies[slot].radius) + 1.2 * radius;
    around.clear();
    forEachNear(home, half + radius, [&](std::uint32_t j) { around.push_back(now_.bodies[j]); });
    while (around.size() % 8 != 0) around.push_back(around.front());
    double most = -std::numeric_limits<double>::infinity();
    Vec<Dim> best = walls_.position(home);
    for (int draw = 0; draw < kDraws; ++draw) {
        Home at = home;
        for (int d = 0; d < Dim; ++d)
            at[static_cast<std::size_t>(d)] +=
                static_cast<std::int64_t>((2 * random.uniform() - 1) * half);
        const Vec<Dim> x = walls_.position(at);
        const double wall = -sampler.signedDistance(x) / quantum_;
        const Body body{lowBits(at[0]), lowBits(at[1]), lowBits(at[2]), 0};
        double space = wall;
        if (wall > most) space = std::min(wall, static_cast<double>(room(around, body)));
        if (space > most && (!belongs || belongs(x))) {
            most = space;
            best = x;
        }
    }
    return best;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                   \
    template std::vector<Relaxation<Dim>::Vacancy> Relaxation<Dim>::vacanciesHere(                 \
        const std::vector<double>&, std::uint64_t);                                                \
    template std::vector<Sphere<Dim>> Relaxation<Dim>::vacancies(const std::vector<double>&,       \
                                                                 const std::vector<std::int32_t>&, \
                                                                 std::uint64_t, const Belongs&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
