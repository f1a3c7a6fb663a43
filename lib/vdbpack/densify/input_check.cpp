#include "vdbpack/densify/input_check.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace vdbpack {

namespace {

template <int Dim>
bool isAnyOverlap(const std::vector<Sphere<Dim>>& given, const PeriodicCell<Dim>& cell) {
    requireUsable(given);
    double largest = 0;
    for (const auto& s : given) largest = std::max(largest, s.radius);
    SpheresWithImages<Dim> repeated;
    if (cell.any()) repeated = withImages(given, cell, largest);
    const std::vector<Sphere<Dim>>& spheres = cell.any() ? repeated.spheres : given;
    std::atomic<bool> found{false};
    const CellLevels<Dim> cells(spheres);
    cells.forEachPair(
        [&] {
            return [&](std::uint32_t, const Sphere<Dim>& a, std::uint32_t, const Sphere<Dim>& b,
                       double square) {
                const double overlap =
                    (a.radius + b.radius - std::sqrt(square)) / std::min(a.radius, b.radius);
                if (overlap > kAcceptedOverlap) found = true;
            };
        },
        [&] { return found.load(std::memory_order_relaxed); });
    return found;
}

}  // namespace

template <int Dim>
void checkOptions(const DensifyOptions& options, std::size_t count, double volume) {
    if (!(options.gap >= 0) || !std::isfinite(options.gap))
        throw ParameterError(fmt::format("`gap` {} mm: must be 0 or more", options.gap));
    if (std::isnan(options.fraction) || options.fraction < 0)
        throw ParameterError(fmt::format(
            "`fraction` {}: is no solid fraction; request 0 (overlaps alone) to {}, or max",
            options.fraction, kMostFraction<Dim>));
    if (std::isfinite(options.fraction) && options.fraction > kMostFraction<Dim>)
        throw ParameterError(fmt::format(
            "`fraction` {}: {} cannot be packed as densely; request at most {}, or max for the "
            "densest pack",
            options.fraction, Measure<Dim>::kSpheres, kMostFraction<Dim>));
    if (options.fixed > count)
        throw ParameterError(fmt::format("`fixed` {}: there are {} {}; fix no more than these",
                                         options.fixed, count, Measure<Dim>::kSpheres));
    if (options.random &&
        (count > 0 || options.local || options.ranks || !options.sizes || !(options.fraction > 0)))
        throw ParameterError(
            "`random`: needs `sizes` and a `fraction`, and works without spheres, `local` and "
            "`ranks`");
    if (!(volume > 0))
        throw InputError(fmt::format("densify: the domain has no {}; check its unit and clips",
                                     Measure<Dim>::kVolume));
    if (!options.regions.empty() && options.regions.size() != count)
        throw ParameterError(fmt::format("`regions`: {} for {} {}; pass one each, or none",
                                         options.regions.size(), count, Measure<Dim>::kSpheres));
}

template <int Dim>
bool isAccepted(const std::vector<Sphere<Dim>>& spheres, std::size_t fixed,
                const Domain<Dim>& domain) {
    if (isAnyOverlap(spheres, domain.cell())) return false;
    const auto sampler = domain.sampler();
    return std::all_of(spheres.begin() + static_cast<std::ptrdiff_t>(fixed), spheres.end(),
                       [&](const Sphere<Dim>& s) {
                           return !sampler->isWallCloser(s.center,
                                                         s.radius * (1 - kAcceptedOverlap)) &&
                                  sampler->contains(s.center);
                       });
}

template void checkOptions<2>(const DensifyOptions&, std::size_t, double);
template void checkOptions<3>(const DensifyOptions&, std::size_t, double);
template bool isAccepted<2>(const std::vector<Sphere<2>>&, std::size_t, const Domain<2>&);
template bool isAccepted<3>(const std::vector<Sphere<3>>&, std::size_t, const Domain<3>&);

}  // namespace vdbpack
