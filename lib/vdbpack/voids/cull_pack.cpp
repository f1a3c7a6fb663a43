// Spheres that voids remove, and what of the rest is connected.
#include "vdbpack/core/error.h"
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
#include <cmath>
#include <utility>

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

}  // namespace

template <int Dim>
void cullPack(const VoidSetting<Dim>& s, double contactTolerance, std::size_t standing,
              MadeVoids<Dim>& made, Pack<Dim>& pack) {
    const VoidRecipe& r = s.recipe;
    const auto* thinning = r.as<Thinning>();
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
    if (thinning) {
        auto candidates = pack.region;
        std::fill_n(candidates.begin(), std::min(standing, before), 0);
        double all = 0;
        for (std::size_t i = 0; i < before; ++i)
            if (pack.region[i]) all += Measure<Dim>::ball(pack.spheres[i].radius);
        const auto bvtvAt = [&](double fraction) {
            fraction = std::max(fraction, 1e-6);
            keep = thinning->by == Thinning::By::threshold
                       ? removeLargest(pack.spheres, candidates, fraction)
                       : removeAround(pack.spheres, candidates, fraction, s.seed, s.domain.cell());
            double left = 0;
            for (std::size_t i = 0; i < before; ++i)
                if (pack.region[i] && keep[i]) left += Measure<Dim>::ball(pack.spheres[i].radius);
            return all > 0 ? left / all : 0.0;
        };
        made.report.ofSpheres = true;
        made.report.totalVolume = regionOf(s).volume();
        if (const auto target = thinning->targetBvtv)
            made.report.amount = solveForBvtv(r, 0, 1 - *target, 1, bvtvTolerance(r), "", bvtvAt);
        else
            made.report.amount = thinning->fraction;
        made.report.bvtv = bvtvAt(*made.report.amount);
        warnIfOff(s, made.report);
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
    if (shell.any() && sumOver(s.ranks, std::uint64_t{pack.spheres.size()}) > 0) {
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
        made.report.cortical = cortical;
        if (cortical > 0) {
            thickness =
                shell.isUniform() ? shell.most() : thickness / static_cast<double>(cortical);
            made.report.across = thickness / (2 * mean / static_cast<double>(cortical));
            if (*made.report.across < 3)
                s.callbacks.warn(
                    fmt::format("the shell of {:.4g} mm is only {:.2g} {} thick; give smaller "
                                "radii or a thicker shell, for a thickness of three or more",
                                thickness, *made.report.across, Measure<Dim>::kSpheres));
        }
    }
}

#define VDBPACK_INSTANTIATE(Dim)                                                          \
    template std::vector<std::uint8_t> attachedToShell(const VoidSetting<Dim>&, double,   \
                                                       const Pack<Dim>&, VoidReport&);    \
    template void cullPack(const VoidSetting<Dim>&, double, std::size_t, MadeVoids<Dim>&, \
                           Pack<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
