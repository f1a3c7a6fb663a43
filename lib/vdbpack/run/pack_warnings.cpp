#include "vdbpack/run/pack_warnings.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace vdbpack {

namespace {

/// Share of connected spheres below which a pack is called loose.
constexpr double kConnected = 0.9;
/// Contact tolerance from which densified spheres count as touching.
constexpr double kDensifiedTolerance = 0.01;

std::string percent(double share) {
    return fmt::format("{:.3g} %", 100 * share);
}

}  // namespace

template <int Dim>
void warnOfLooseSpheres(const Run<Dim>& run) {
    const Report& report = run.report;
    const double tolerance = run.settings.contactTolerance;
    if (report.interrupted || report.requestedGap > 0 || !report.contacts || report.count < 2 ||
        (report.densified && tolerance < kDensifiedTolerance))
        return;
    const char* spheres = Measure<Dim>::kSpheres;
    const VoidReport& voids = run.voids.report;
    const bool anchored = run.cuts() && (voids.shell == 0 || voids.cortical > 0);
    if (const auto attached = anchored ? voids.spheresAttached : std::nullopt) {
        if (*attached < kConnected && !run.voidRecipe->keepConnected)
            run.callbacks.warn(fmt::format(
                "only {} of the {} are connected to the {} by contacts. Set `keepConnected` to "
                "remove the others, or give larger voids or smaller radii",
                percent(*attached), spheres,
                run.voidRecipe->shell > 0 ? "shell" : "largest component"));
        return;
    }
    if (report.contacts->largestComponent < kConnected)
        run.callbacks.warn(fmt::format(
            "the largest connected component has only {} of the {}, at a contact tolerance of {}. "
            "Give smaller radii, or check whether the domain has several components",
            percent(report.contacts->largestComponent), spheres, tolerance));
}

template <int Dim>
void warnOfSmallVoids(const Run<Dim>& run) {
    if (!run.hasPack || run.solid || run.voids.list.empty() || run.pack.spheres.empty()) return;
    std::vector<double> widths;
    for (const auto& v : run.voids.list) widths.push_back(std::min(v.a, v.b));
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end());
    double mean = 0;
    for (const auto& s : run.pack.spheres) mean += s.radius;
    mean /= static_cast<double>(run.pack.spheres.size());
    if (*middle >= mean) return;
    run.callbacks.warn(fmt::format(
        "the voids are smaller than the {}: half of their shorter half-axes are at most {:.3g} mm, "
        "the mean radius is {:.3g} mm. The pack does not show the BV/TV of its level set. Give "
        "larger voids or smaller radii",
        Measure<Dim>::kSpheres, *middle, mean));
}

template <int Dim>
void requireSpheresLeft(const Run<Dim>& run, std::size_t before) {
    if (before == 0 || !run.pack.spheres.empty() || run.report.interrupted) return;
    const auto& bvtv = run.voids.report.bvtv;
    throw ParameterError(fmt::format(
        "`voids` {}: remove all {} {}{}. Give fewer or smaller voids, or a higher `targetBvtv`",
        run.voidRecipe->method, before, Measure<Dim>::kSpheres,
        bvtv ? fmt::format(" and leave a BV/TV of {:.4f}", *bvtv) : std::string()));
}

#define VDBPACK_INSTANTIATE(Dim)                            \
    template void warnOfLooseSpheres<Dim>(const Run<Dim>&); \
    template void warnOfSmallVoids<Dim>(const Run<Dim>&);   \
    template void requireSpheresLeft<Dim>(const Run<Dim>&, std::size_t);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
