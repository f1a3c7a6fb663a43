#include "vdbpack/measure/contacts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/cell_levels.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

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
    tbb::enumerable_thread_specific<double> smallest(result.smallestGap);
    const CellLevels<Dim> cells(spheres, tolerance);
    cells.forEachPair(
        [&](std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j, const Sphere<Dim>& b,
            double d2) {
            counts[i].fetch_add(1, std::memory_order_relaxed);
            counts[j].fetch_add(1, std::memory_order_relaxed);
            double& mine = smallest.local();
            mine = std::min(mine, std::sqrt(d2) - a.radius - b.radius);
        },
        [] { return false; });
    for (const double gap : smallest) result.smallestGap = std::min(result.smallestGap, gap);
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

template <int Dim>
std::optional<double> smallestGap(const std::vector<Sphere<Dim>>& spheres, std::size_t standing) {
    requireUsable(spheres);
    if (spheres.size() < 2 || spheres.size() <= standing) return std::nullopt;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double smallest = kInfinity;
    for (const auto& s : spheres) smallest = std::min(smallest, s.radius);
    // Pairs are sought up to a gap in proportion to their radii: wide enough once no pair of the
    // smallest spheres could be closer than what was found.
    for (double slack = 0.01;;) {
        tbb::enumerable_thread_specific<double> found(kInfinity);
        const CellLevels<Dim> cells(spheres, slack);
        cells.forEachPair(
            [&](std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j, const Sphere<Dim>& b,
                double d2) {
                if (i < standing && j < standing) return;
                double& mine = found.local();
                mine = std::min(mine, std::sqrt(d2) - a.radius - b.radius);
            },
            [] { return false; });
        const double gap = found.combine([](double a, double b) { return std::min(a, b); });
        if (gap <= slack * smallest) return gap;
        slack = gap < kInfinity ? gap / smallest * (1 + 1e-9) : 8 * slack;
    }
}

template std::optional<double> smallestGap<2>(const std::vector<Sphere<2>>&, std::size_t);
template std::optional<double> smallestGap<3>(const std::vector<Sphere<3>>&, std::size_t);
template ContactCheck countContacts<2>(const std::vector<Sphere<2>>&, double,
                                       const std::vector<float>&);
template ContactCheck countContacts<3>(const std::vector<Sphere<3>>&, double,
                                       const std::vector<float>&);

}  // namespace vdbpack
