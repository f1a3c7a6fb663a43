#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

/// Share of connected spheres below which a pack is called loose.
constexpr double kConnected = 0.9;
/// Share of the spheres above which it is said that they were removed for want of contacts.
constexpr double kMostDropped = 0.5;
/// Share of a solid that spheres fill at the least, where it is a few of them thick.
constexpr double kFilled = 0.4;
/// How far a count may be from its target.
constexpr double kCountTolerance = 0.02;
/// Solid fraction below which a pack is called empty.
constexpr double kLeastSolid = 0.1;
/// The radii are others than those requested from this Kolmogorov-Smirnov distance on, and from
/// this number divided by the square root of the number of spheres: few spheres scatter.
constexpr double kOtherRadii = 0.05, kFewRadii = 2.5;

std::string percent(double share) {
    return fmt::format("{:.3g} %", 100 * share);
}

/// About the share of the domain in its largest component, as of two separate bones: a cavity is
/// taken from the smallest body whose bounds hold it.
double largestBody(const DomainSource& source) {
    if (!source.mesh() || !source.isWhole()) return 1;
    const TriangleMesh& mesh = *source.mesh();
    const ShellAnalysis analysis = analyzeShells(mesh);
    const std::vector<Shell>& shells = analysis.shells;  // by falling volume
    std::vector<Box<3>> bounds(shells.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            bounds[analysis.shellOfTriangle[t]].add(mesh.vertices[v]);
    std::vector<double> volume(shells.size());
    for (std::size_t k = 0; k < shells.size(); ++k) {
        std::size_t body = k;
        if (shells[k].depth % 2 == 1)
            for (std::size_t outer = k; outer-- > 0 && body == k;)
                if (shells[outer].depth % 2 == 0 && bounds[outer].contains(bounds[k].lo) &&
                    bounds[outer].contains(bounds[k].hi))
                    body = outer;
        volume[body] += (shells[k].depth % 2 == 1 ? -1 : 1) * std::fabs(shells[k].signedVolume);
    }
    const double all = std::accumulate(volume.begin(), volume.end(), 0.0);
    return all > 0 ? *std::max_element(volume.begin(), volume.end()) / all : 1;
}

}  // namespace

template <int Dim>
void warnOfLooseSpheres(const Run<Dim>& run) {
    const Report& report = run.report;
    if (report.interrupted || report.requestedGap > 0 || !report.contacts || report.count < 2)
        return;
    const char* spheres = Measure<Dim>::kSpheres;
    const VoidReport& voids = run.voids.made.report;
    const bool anchored = run.cuts() && (voids.shell == 0 || voids.cortical > 0);
    if (const auto attached = anchored ? voids.spheresAttached : std::nullopt) {
        const auto dropped = static_cast<double>(voids.dropped);
        const double before = dropped + static_cast<double>(report.count);
        if (run.voids.recipe.keepConnected && dropped > kMostDropped * before)
            run.callbacks.warn(fmt::format(
                "`keepConnected` removed {} of the {}, which no contact connects. Give larger "
                "voids "
                "or smaller radii, or count wider gaps as contacts by `contactTolerance`",
                percent(dropped / before), spheres));
        else if (*attached < kConnected && !run.voids.recipe.keepConnected)
            run.callbacks.warn(fmt::format(
                "only {} of the {} are connected to the {} by contacts. Set `keepConnected` to "
                "remove the others, or give larger voids or smaller radii",
                percent(*attached), spheres,
                run.voids.recipe.hasShell() ? "shell" : "largest component"));
        return;
    }
    // Contacts are reported at a tolerance at which densified spheres hardly touch.
    if (run.connectionTolerance() > run.settings.contactTolerance) return;
    const double share = report.contacts->largestComponent;
    if (share >= kConnected || share >= kConnected * largestBody(*run.source)) return;
    run.callbacks.warn(fmt::format(
        "the largest connected component has only {} of the {}, at a contact tolerance of {}. "
        "Give smaller radii, or a wider `contactTolerance`",
        percent(share), spheres, run.settings.contactTolerance));
}

template <int Dim>
void warnOfSizes(const Run<Dim>& run, double largest) {
    const Report& report = run.report;
    if (report.interrupted || (run.cuts() && !run.solid) || report.existing > 0) return;
    const char* spheres = Measure<Dim>::kSpheres;
    const auto room = [&] {
        return run.ranks() ? std::string()
                           : fmt::format(" (at most {:.4g} mm)", largestBall(run.filled()).radius);
    };
    if (!run.cuts() && report.requestedGap == 0 &&
        report.solidFractionTotal.value_or(1) < kLeastSolid)
        run.callbacks.warn(fmt::format(
            "the {} fill only {} of the domain, since those of up to {:.3g} mm hardly fit. Give a "
            "smaller largest radius{}",
            spheres, percent(*report.solidFractionTotal), largest, room()));
    else if (report.ks.value_or(0) >
             std::max(kOtherRadii, kFewRadii / std::sqrt(static_cast<double>(report.count))))
        run.callbacks.warn(fmt::format(
            "the radii are not those requested (Kolmogorov-Smirnov distance {:.2g}): {}",
            *report.ks,
            !report.localSizes.empty() && (report.densified || report.seconds.settle > 0)
                ? fmt::format("{} that move across a jump of the sizes keep theirs", spheres)
                : fmt::format("{} of up to {:.3g} mm found room in few places. Give a smaller "
                              "largest radius{}",
                              spheres, largest, room())));
}

template <int Dim>
void warnOfThinSolid(const Run<Dim>& run) {
    const VoidReport& voids = run.voids.made.report;
    if (!run.solid || !run.hasPack || run.report.interrupted || !voids.bvtv) return;
    double filled = 0;
    for (std::size_t i = 0; i < run.pack.spheres.size(); ++i)
        if (run.pack.region.empty() || run.pack.region[i] != 0)
            filled += Measure<Dim>::ball(run.pack.spheres[i].radius);
    const double share = sumOver(run.ranks(), filled) / (*voids.bvtv * voids.totalVolume);
    if (share < kFilled)
        run.callbacks.warn(fmt::format(
            "the {} fill only {} of the solid between the voids, which is hardly thicker than "
            "they are. Give smaller radii, larger voids or a higher BV/TV",
            Measure<Dim>::kSpheres, percent(share)));
}

template <int Dim>
void warnOfCount(const Run<Dim>& run, double target, double count, double largest) {
    constexpr double kAlmost = 0.9;
    if (!(target > 0) || run.report.interrupted ||
        std::fabs(count - target) <= std::max(kCountTolerance * target, 0.5))
        return;
    std::string reason;
    if (largest > 0 && count > target && !run.ranks() && !run.solid) {
        const double room = largestBall(run.filled()).radius;
        if (largest > kAlmost * room)
            reason = fmt::format(", since none of more than {:.4g} mm fits into the domain", room);
    }
    run.callbacks.warn(
        fmt::format("`targetCount` {:.0f}: the nearest count found is {:.0f}{}; give another "
                    "number, or the radii themselves",
                    target, count, reason));
}

template <int Dim>
void warnOfSmallVoids(const Run<Dim>& run) {
    if (!run.hasPack || run.solid || run.voids.made.list.empty() || run.pack.spheres.empty())
        return;
    std::vector<double> widths;
    for (const auto& v : run.voids.made.list) widths.push_back(std::min(v.a, v.b));
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
void requireSpheresLeft(const Run<Dim>& run, std::uint64_t before) {
    before = sumOver(run.ranks(), before);
    const std::uint64_t left = sumOver(run.ranks(), std::uint64_t{run.pack.spheres.size()});
    if (before == 0 || left > 0 || run.report.interrupted) return;
    const auto& bvtv = run.voids.made.report.bvtv;
    throw ParameterError(fmt::format(
        "`voids` {}: remove all {} {}{}. Give fewer or smaller voids, or a higher `targetBvtv`",
        nameOf(run.voids.recipe), before, Measure<Dim>::kSpheres,
        bvtv ? fmt::format(" and leave a BV/TV of {:.4f}", *bvtv) : std::string()));
}

#define VDBPACK_INSTANTIATE(Dim)                                             \
    template void warnOfLooseSpheres<Dim>(const Run<Dim>&);                  \
    template void warnOfSizes<Dim>(const Run<Dim>&, double);                 \
    template void warnOfThinSolid<Dim>(const Run<Dim>&);                     \
    template void warnOfCount<Dim>(const Run<Dim>&, double, double, double); \
    template void warnOfSmallVoids<Dim>(const Run<Dim>&);                    \
    template void requireSpheresLeft<Dim>(const Run<Dim>&, std::uint64_t);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
