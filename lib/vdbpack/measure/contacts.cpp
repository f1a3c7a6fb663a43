#include "vdbpack/measure/contacts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/cell_levels.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>

namespace vdbpack {

template <int Dim>
ContactCheck countContacts(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                           const std::vector<float>& depth) {
    if (!(tolerance >= 0 && tolerance <= 1))
        throw ParameterError(fmt::format(
            "contacts: tolerance {} is not a share of a radius from 0 to 1", tolerance));
    if (!depth.empty() && depth.size() != spheres.size())
        throw ParameterError(fmt::format("contacts: {} depths for {} {}; give one each or none",
                                         depth.size(), spheres.size(), Measure<Dim>::kSpheres));
    requireUsable(spheres);
    ContactCheck result;
    std::vector<std::atomic<std::int32_t>> counts(spheres.size());
    const CellLevels<Dim> cells(spheres, tolerance);
    cells.forEachPair(
        [&](std::uint32_t i, const Sphere<Dim>&, std::uint32_t j, const Sphere<Dim>&, double) {
            counts[i].fetch_add(1, std::memory_order_relaxed);
            counts[j].fetch_add(1, std::memory_order_relaxed);
        },
        [] { return false; });
    result.counts.resize(spheres.size());
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        result.counts[i] = counts[i].load(std::memory_order_relaxed);
        sum += static_cast<std::uint64_t>(result.counts[i]);
    }
    result.pairs = sum / 2;
    for (std::size_t i = 0; i < depth.size(); ++i) {
        const double r = spheres[i].radius;
        if (!(std::abs(static_cast<double>(depth[i]) - r) <= tolerance * r)) continue;
        ++result.counts[i];
        ++result.wallContacts;
    }
    if (!spheres.empty())
        result.mean =
            static_cast<double>(sum + result.wallContacts) / static_cast<double>(spheres.size());
    return result;
}

template ContactCheck countContacts<2>(const std::vector<Sphere<2>>&, double,
                                       const std::vector<float>&);
template ContactCheck countContacts<3>(const std::vector<Sphere<3>>&, double,
                                       const std::vector<float>&);

}  // namespace vdbpack
