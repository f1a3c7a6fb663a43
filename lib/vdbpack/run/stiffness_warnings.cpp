#include "vdbpack/run/stiffness_warnings.h"

#include "vdbpack/core/disjoint_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbpack {

namespace {

/// Share of the spheres that bonds hold below which a warning says so.
constexpr double kHeld = 0.97;
/// Spheres at the wall, and the share of it that they cover: a pack has at least these. A dense one
/// covers half of its wall, one with a fifth of its solid a tenth.
constexpr std::uint64_t kFewHeld = 20;
constexpr double kLeastCovered = 0.04;
/// How much more than others the spheres of bonds across the faces of a cell overlap, on average
/// and in smaller radii, and by which share such bonds are fewer, where it is another pack's.
constexpr double kPressed = 0.02, kWeakFace = 0.4;

}  // namespace

Box<3> boxAround(const Pack<3>& pack) {
    Box<3> box;
    for (const Sphere<3>& s : pack.spheres) {
        box.add(s.center - Box<3>::filled(s.radius));
        box.add(s.center + Box<3>::filled(s.radius));
    }
    return box;
}

void warnOfOtherEnds(const Pack<3>& pack, const Box<3>& bounds, const std::string& domain,
                     bool isBox, bool beyond, const Callbacks& callbacks) {
    constexpr double kReaches = 0.8, kReachesBox = 0.88, kReachesCell = 0.97, kBeyond = 1.02;
    const Vec<3> size = boxAround(pack).size();
    for (int d = 0; d < 3; ++d) {
        const double share = size[d] / bounds.size()[d];
        const bool wraps = pack.cell.isAlong(d);
        // A box has no thin ends, which spheres cannot fill.
        const double least = wraps ? kReachesCell : isBox ? kReachesBox : kReaches;
        if (share >= least && (wraps || !beyond || share <= kBeyond)) continue;
        callbacks.warn(
            fmt::format("the spheres reach through {:.0f} % of {} along {}, so that its volume and "
                        "cross-section are not theirs; check `domain`, `label`, `mask` and `clip`",
                        100 * share, domain, "xyz"[d]));
        return;
    }
}

void warnOfFewHeld(const Pack<3>& pack, const std::vector<std::uint8_t>& boundary, double wall,
                   bool named, const Callbacks& callbacks) {
    std::uint64_t held = 0;
    double covered = 0;
    for (std::size_t i = 0; i < boundary.size(); ++i)
        if (boundary[i]) {
            ++held;
            covered += Measure<2>::ball(pack.spheres[i].radius);
        }
    if (held >= kFewHeld && covered >= kLeastCovered * wall) return;
    callbacks.warn(fmt::format(
        "only {} spheres, on {:.2g} % of the wall, move with the boundary, which tells little of "
        "the pack; set the `domain` of the pack{}, or a larger `boundary`",
        held, 100 * covered / wall, named ? "" : ", of a periodic one its cell"));
}

void warnOfOtherCell(const std::string& file, const PeriodicCell<3>& stated,
                     const PeriodicCell<3>& named, const Callbacks& callbacks) {
    const Vec<3> own = stated.box.size();
    if (stated.any() && (!named.any() || length(named.box.size() - own) > 1e-6 * length(own)))
        callbacks.warn(fmt::format(
            "{}: states a periodic cell of {:.6g} x {:.6g} x {:.6g} mm, which `domain` is not; "
            "leave `domain` out",
            file, own[0], own[1], own[2]));
}

void warnOfLoose(const Pack<3>& pack, const std::vector<Bond>& bonds,
                 const std::vector<std::uint8_t>& boundary, const Callbacks& callbacks) {
    const std::size_t n = pack.spheres.size();
    const auto wall = static_cast<std::uint32_t>(n);
    DisjointSets sets(n + 1);
    for (const Bond& b : bonds) sets.join(b.i, b.j);
    for (std::uint32_t i = 0; i < boundary.size(); ++i)
        if (boundary[i]) sets.join(i, wall);
    std::vector<std::size_t> members(n + 1);
    for (std::uint32_t i = 0; i < n; ++i) ++members[sets.find(i)];
    const std::size_t held = boundary.empty() ? *std::max_element(members.begin(), members.end())
                                              : members[sets.find(wall)];
    const double share = static_cast<double>(held) / static_cast<double>(n);
    if (share < kHeld)
        callbacks.warn(
            fmt::format("bonds connect only {:.3g} % of the spheres to {}; the others carry "
                        "nothing. Set a larger "
                        "`contactTolerance` (of several parts `interfaceTolerance`), or the "
                        "`domain` of the pack",
                        100 * share, boundary.empty() ? "one another" : "the boundary"));
}

void warnOfCellFit(const Pack<3>& pack, const std::vector<Bond>& bonds,
                   const Callbacks& callbacks) {
    for (int d = 0; d < 3; ++d) {
        if (!pack.cell.isAlong(d)) continue;
        const double side = pack.cell.box.size()[d];
        double cut = 0;                  // bonds that a plane across the axis cuts, on average
        std::array<double, 2> number{};  // of bonds within the cell, and across its faces
        std::array<double, 2> overlap{};
        for (const Bond& b : bonds) {
            const Sphere<3>&i = pack.spheres[b.i], &j = pack.spheres[b.j];
            const Vec<3> branch = b.direction * b.length;
            const bool across = std::abs((j.center - i.center - branch)[d]) > side / 2;
            cut += std::abs(branch[d]) / side;
            ++number[across];
            overlap[across] += (i.radius + j.radius - b.length) / std::min(i.radius, j.radius);
        }
        if (number[1] > 0 &&
            overlap[1] / number[1] > overlap[0] / std::max(1.0, number[0]) + kPressed)
            callbacks.warn(fmt::format(
                "spheres overlap across the faces of the periodic cell along {}, whose {:.6g} mm "
                "are not the pack's; check `domain`",
                "xyz"[d], side));
        else if (number[1] < kWeakFace * cut)
            callbacks.warn(fmt::format(
                "bonds across the faces of the periodic cell along {} are {:.0f}, where a plane "
                "within it cuts about {:.0f}: its {:.6g} mm are not the pack's, or the pack has "
                "walls there; check `domain`",
                "xyz"[d], number[1], cut, side));
    }
}

}  // namespace vdbpack
