// Spheres that voids remove, and what of the rest is connected.
#include "vdbpack/core/sphere.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/make_voids.h"
#include "vdbpack/voids/solve_target.h"
#include "vdbpack/voids/stamped_solid.h"
#include "vdbpack/voids/thinning.h"
#include "vdbpack/voids/void_families.h"

#include <fmt/format.h>

#include <algorithm>

namespace vdbpack {

template <int Dim>
std::vector<std::uint8_t> attachedToShell(const VoidSetting<Dim>& s, double contactTolerance,
                                          const Pack<Dim>& pack, VoidReport& report) {
    auto attached = attachedSpheres(pack.spheres,
                                    s.recipe.hasShell() ? pack.region : std::vector<std::int32_t>{},
                                    contactTolerance, s.domain.cell());
    const auto held = static_cast<double>(std::count(attached.begin(), attached.end(), 1));
    if (!attached.empty()) report.spheresAttached = held / static_cast<double>(attached.size());
    return attached;
}

namespace {

/// Spheres where voids are known: in the cell in which they repeat.
template <int Dim>
std::vector<Sphere<Dim>> wrappedInto(const PeriodicCell<Dim>& cell,
                                     std::vector<Sphere<Dim>> spheres) {
    for (Sphere<Dim>& s : spheres) s.center = cell.wrapped(s.center);
    return spheres;
}

/// Which spheres thinning keeps of those below the shell.
/// @param fixed  number of the first spheres, which stay.
template <int Dim>
std::vector<std::uint8_t> keptByThinning(const VoidSetting<Dim>& s, const Thinning& thinning,
                                         std::size_t fixed, const Pack<Dim>& pack,
                                         VoidReport& report) {
    auto candidates = pack.region;
    std::fill_n(candidates.begin(), fixed, 0);
    double all = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        if (pack.region[i]) all += Measure<Dim>::ball(pack.spheres[i].radius);
    std::vector<std::uint8_t> keep;
    const auto bvtvAt = [&](double fraction) {
        fraction = std::max(fraction, 1e-6);
        keep = thinning.by == Thinning::By::threshold
                   ? removeLargest(pack.spheres, candidates, fraction)
                   : removeAround(pack.spheres, candidates, fraction, s.seed, s.domain.cell());
        double left = 0;
        for (std::size_t i = 0; i < pack.spheres.size(); ++i)
            if (pack.region[i] && keep[i]) left += Measure<Dim>::ball(pack.spheres[i].radius);
        return all > 0 ? left / all : 0.0;
    };
    report.ofSpheres = true;
    report.totalVolume = regionOf(s).volume();
    if (const auto target = thinning.targetBvtv)
        report.amount =
            solveForBvtv(s.recipe, 0, 1 - *target, 1, bvtvTolerance(s.recipe), "", bvtvAt);
    else
        report.amount = thinning.fraction;
    report.bvtv = bvtvAt(*report.amount);
    warnIfOff(s, report);
    return keep;
}

/// How many spheres lie in the shell, and how many of them lie side by side across it.
template <int Dim>
void measureShell(const VoidSetting<Dim>& s, const ShellThickness& shell, const Pack<Dim>& pack,
                  VoidReport& report) {
    double mean = 0, thickness = 0;
    std::uint64_t cortical = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        if (pack.region[i]) continue;
        mean += pack.spheres[i].radius;
        thickness += shell.at(pack.spheres[i].center);
        ++cortical;
    }
    mean = sumOver(s.ranks, mean);
    thickness = sumOver(s.ranks, thickness);
    cortical = sumOver(s.ranks, cortical);
    report.cortical = cortical;
    if (cortical == 0) return;
    thickness = shell.isUniform() ? shell.most() : thickness / static_cast<double>(cortical);
    report.across = thickness / (2 * mean / static_cast<double>(cortical));
    if (*report.across < 3)
        s.callbacks.warn(
            fmt::format("the shell of {:.4g} mm is only {:.1f} {} thick; give smaller radii or a "
                        "thicker shell, for a thickness of three or more",
                        thickness, *report.across, Measure<Dim>::kSpheres));
}

}  // namespace

template <int Dim>
void cullPack(const VoidSetting<Dim>& s, double contactTolerance, std::size_t standing,
              MadeVoids<Dim>& made, Pack<Dim>& pack) {
    const VoidRecipe& r = s.recipe;
    if (r.empty() && !r.hasShell()) {
        pack.region.assign(pack.spheres.size(), 0);  // all compact
        return;
    }
    made.report.method = nameOf(r);
    const ShellThickness shell = shellOf(s);
    noteShell(s, made.report);
    pack.region = deeperThan(pack.spheres, s.domain, shell);
    const std::size_t before = pack.spheres.size();
    std::vector<std::uint8_t> keep;
    if (const auto* thinning = r.as<Thinning>()) {
        keep = keptByThinning(s, *thinning, std::min(standing, before), pack, made.report);
    } else if (made.stamped && r.fill == Fill::domain) {
        const auto spheres = wrappedInto(s.domain.cell(), pack.spheres);
        keep = r.cull == Cull::touch
                   ? spheresOutside(spheres, *made.stamped, r.cull)
                   : centersOutside(spheres, made.list, *made.stamped, pack.region);
    }
    if (!keep.empty()) {
        std::fill_n(keep.begin(), std::min(standing, before), 1);
        keepOnly(pack, keep);
    }
    made.report.culled = sumOver(s.ranks, std::uint64_t{before - pack.spheres.size()});
    if (r.keepConnected) {
        auto stay = attachedToShell(s, contactTolerance, pack, made.report);
        std::fill_n(stay.begin(), std::min(standing, stay.size()), 1);
        const std::size_t count = pack.spheres.size();
        keepOnly(pack, stay);
        made.report.dropped = count - pack.spheres.size();
    }
    if (shell.any() && sumOver(s.ranks, std::uint64_t{pack.spheres.size()}) > 0)
        measureShell(s, shell, pack, made.report);
}

template std::vector<std::uint8_t> attachedToShell(const VoidSetting<2>&, double, const Pack<2>&,
                                                   VoidReport&);
template void cullPack(const VoidSetting<2>&, double, std::size_t, MadeVoids<2>&, Pack<2>&);
template std::vector<std::uint8_t> attachedToShell(const VoidSetting<3>&, double, const Pack<3>&,
                                                   VoidReport&);
template void cullPack(const VoidSetting<3>&, double, std::size_t, MadeVoids<3>&, Pack<3>&);

}  // namespace vdbpack
