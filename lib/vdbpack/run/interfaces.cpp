#include "vdbpack/run/interfaces.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/run/part_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Points that are spread over the wall of a part, and how far outside of it they are, in roots of
/// the area of their triangle.
constexpr std::size_t kWallPoints = 20000;
constexpr double kOutside = 1e-3;
/// Share of the bonds of the bulk below which an interface is weak, if it should have so many.
constexpr double kWeak = 0.5, kFew = 4;
/// Largest gap, in smaller radii, of pairs that are sought as bonds of an interface.
constexpr double kFar = 1;

/// Points just outside of the wall of a part, spread evenly over it.
struct WallPoints {
    std::vector<Vec<3>> points;
    double area = 0;  ///< of the wall, mm²

    explicit WallPoints(const TriangleMesh& wall) : points(kWallPoints) {
        const auto corner = [&](std::size_t t, std::size_t k) {
            return wall.vertices[wall.triangles[t][k]];
        };
        std::vector<double> ends;
        for (std::size_t t = 0; t < wall.triangles.size(); ++t) {
            const Vec<3> a = corner(t, 0);
            area += 0.5 * length(cross(corner(t, 1) - a, corner(t, 2) - a));
            ends.push_back(area);
        }
        forAll(kWallPoints, [&](std::size_t n) {
            const double at = (static_cast<double>(n) + 0.5) / kWallPoints * area;
            const auto t = static_cast<std::size_t>(
                std::upper_bound(ends.begin(), ends.end() - 1, at) - ends.begin());
            const Vec<3> a = corner(t, 0), ab = corner(t, 1) - a, ac = corner(t, 2) - a;
            const Vec<3> across = cross(ab, ac);
            RandomStream random(0, n);
            const double u = std::sqrt(random.uniform()), v = u * random.uniform();
            const double twice = std::max(length(across), std::numeric_limits<double>::min());
            points[n] = a + ab * (u - v) + ac * v + across * (kOutside / std::sqrt(twice));
        });
    }

    /// The area where another part lies there, mm².
    double areaIn(const MeshSides& other) const {
        std::vector<std::uint8_t> common(points.size());
        forAll(points.size(), [&](std::size_t n) { common[n] = other.inside(points[n]); });
        const auto found = std::count(common.begin(), common.end(), std::uint8_t{1});
        return area * static_cast<double>(found) / kWallPoints;
    }
};

/// Pairs of spheres, and their lengths together.
struct Joined {
    std::uint64_t pairs = 0;
    double length = 0;

    /// Those that a plane through a part cuts, per mm², on average over all directions: half of
    /// their length per volume.
    double perArea(double volume) const { return volume > 0 ? 0.5 * length / volume : 0; }
};

/// Pairs by the parts of their spheres.
template <class Pair>
std::map<PartPair, Joined> joinedParts(const Pack<3>& pack, const Materials& materials,
                                       const std::vector<Pair>& pairs) {
    std::map<PartPair, Joined> all;
    for (const Pair& b : pairs) {
        Joined& one = all[std::minmax({materials.partOf(b.i), materials.partOf(b.j)})];
        ++one.pairs;
        one.length +=
            length(pack.cell.nearest(pack.spheres[b.j].center - pack.spheres[b.i].center));
    }
    return all;
}

/// The tolerance with which an interface has so many bonds; nothing if there are fewer pairs.
std::optional<double> toleranceFor(double wanted, const PartPair& two, const Pack<3>& pack,
                                   const Materials& materials) {
    // Spheres deep in their part have no pairs across.
    double reach = 0;
    for (const Sphere<3>& s : pack.spheres) reach = std::max(reach, 2 * s.radius);
    Pack<3> near;
    std::vector<std::int32_t> of;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const std::int32_t part = materials.partOf(i);
        if ((part != two.first && part != two.second) ||
            (!pack.depth.empty() && static_cast<double>(pack.depth[i]) > reach))
            continue;
        near.spheres.push_back(pack.spheres[i]);
        of.push_back(part);
    }
    std::vector<double> gaps;
    for (const Contact& c : listContacts(near.spheres, kFar, pack.cell))
        if (of[c.i] != of[c.j])
            gaps.push_back(c.gap / std::min(near.spheres[c.i].radius, near.spheres[c.j].radius));
    const auto count = static_cast<std::size_t>(std::ceil(wanted));
    if (count == 0 || gaps.size() < count) return std::nullopt;
    const auto nth = gaps.begin() + static_cast<std::ptrdiff_t>(count - 1);
    std::nth_element(gaps.begin(), nth, gaps.end());
    return std::ceil(*nth * 100) / 100;
}

void warnOfWeak(const InterfaceReport& r, const PartPair& two, const Pack<3>& pack,
                const Materials& materials, const Callbacks& callbacks) {
    const double bulk = std::min(r.bulk[0], r.bulk[1]);
    if (!(r.perArea() < kWeak * bulk) || bulk * r.area < kFew) return;
    const auto enough = toleranceFor(bulk * r.area, two, pack, materials);
    callbacks.warn(fmt::format(
        "{} and {}: {} on {:.4g} mm² of their common wall, {:.2g} per mm², where a plane through "
        "{} cuts {:.2g}, so that the interface is a weak plane{}",
        r.parts[0], r.parts[1], r.pairs == 1 ? "1 bond" : fmt::format("{} bonds", r.pairs), r.area,
        r.perArea(), r.parts[r.bulk[0] <= r.bulk[1] ? 0 : 1], bulk,
        enough ? fmt::format("; `interfaceTolerance` {:g} gives it as many", *enough)
               : "; give smaller radii"));
}

}  // namespace

std::uint64_t contactsBetweenParts(const Pack<3>& pack, double tolerance) {
    const Materials materials(pack);
    std::uint64_t pairs = 0;
    for (const Contact& c : listContacts(pack.spheres, tolerance))
        pairs += materials.partOf(c.i) != materials.partOf(c.j);
    return pairs;
}

void warnOfModuli(const PackAttributes& pack, const BondLaw& law, const Callbacks& callbacks) {
    constexpr double kLeast = 20, kMost = 1e6, kDenserThanBone = 2500, kLeastOfDense = 2000;
    const auto warn = [&](const std::string& whose, double modulus) {
        callbacks.warn(fmt::format(
            "{} a Young's modulus of {:.3g} MPa; moduli are in MPa, of bone tissue some 1,000 to "
            "20,000, of titanium 110,000: check `modulus`, `bond-modulus` or `bond-modulus-for`",
            whose, modulus));
    };
    const auto materials = materialsOf(pack);
    const auto own = [](const MaterialReport& m) { return m.modulus.has_value(); };
    if (std::none_of(materials.begin(), materials.end(), own) &&
        (law.modulus < kLeast || law.modulus > kMost))
        warn("bonds have", law.modulus);
    for (const MaterialReport& m : materials) {
        if (!m.modulus) continue;
        const double least = m.modulus->front(), middle = (*m.modulus)[1], most = m.modulus->back();
        // A metal in GPa; an implant softer than the bone whose moduli follow grey values.
        const bool dense = least == most && m.density && (*m.density)[1] > kDenserThanBone;
        const bool soft =
            least == most &&
            std::any_of(materials.begin(), materials.end(), [&](const MaterialReport& other) {
                return other.modulus && other.modulus->front() < other.modulus->back() &&
                       middle < (*other.modulus)[1];
            });
        if (middle < kLeast || middle > kMost || soft || (dense && middle < kLeastOfDense))
            warn((m.part.empty() ? "the spheres have" : m.part + " has") +
                     std::string(least < most ? " in the middle" : ""),
                 middle);
    }
}

void warnOfBondLaw(const BondLaw& law, const Callbacks& callbacks) {
    constexpr double kThinnest = 0.02, kThickest = 2, kMostShear = 5, kMostStrain = 0.05,
                     kMostPercent = 20;
    if (law.radiusFactor < kThinnest || law.radiusFactor > kThickest)
        callbacks.warn(fmt::format(
            "`bond-radius` {:g} is a factor on the smaller sphere's radius, usually 0.2 "
            "to 1, and no length; stiffness grows with its square",
            law.radiusFactor));
    if (law.shearRatio > kMostShear)
        callbacks.warn(fmt::format("`bond-shear` {:g} is the ratio k_t / k_n, usually 0 to 1",
                                   law.shearRatio));
    if (law.breakingStrain.value_or(0) > kMostStrain)
        callbacks.warn(fmt::format(
            "`bond-strength` {:g} is the strain at which bonds break as a share, of bone "
            "about 0.01: {}",
            *law.breakingStrain,
            *law.breakingStrain < kMostPercent
                ? fmt::format("for {:g} % write {:g}", *law.breakingStrain,
                              *law.breakingStrain / 100)
                : "a strength in MPa has to be divided by Young's modulus in MPa"));
    if (law.shearStrength > kMostShear)
        callbacks.warn(
            fmt::format("`bond-shear-strength` {:g} is the strength in shear divided by that in "
                        "tension, usually "
                        "0.5 to 3",
                        law.shearStrength));
}

std::vector<MaterialReport> materialsOf(const PackAttributes& pack) {
    const Column* density = columnOfNumbers(pack, kDensityColumn);
    const Column* modulus = columnOfNumbers(pack, kModulusColumn);
    const Column* part = columnOfNumbers(pack, kPartColumn);
    if (!density && !modulus) return {};
    const auto names = partNames(pack);
    std::map<std::int64_t, MaterialReport> found;
    const auto add = [&](const Column* column, auto MaterialReport::*value) {
        std::map<std::int64_t, std::vector<double>> own;
        for (std::size_t i = 0; column && i < column->numbers.size(); ++i)
            own[part ? static_cast<std::int64_t>(part->numbers[i]) : 0].push_back(
                column->numbers[i]);
        for (auto& [k, of] : own) {
            std::sort(of.begin(), of.end());
            found[k].*value = {of.front(), of[of.size() / 2], of.back()};
        }
    };
    add(density, &MaterialReport::density);
    add(modulus, &MaterialReport::modulus);
    std::vector<MaterialReport> all;
    for (auto& [k, one] : found) {
        const auto n = static_cast<std::size_t>(k);
        if (part) one.part = n < names.size() ? names[n] : fmt::format("part {}", k);
        all.push_back(std::move(one));
    }
    return all;
}

void warnOfUnusedBonds(const PackAttributes& pack, const PackOrigin& origin,
                       const BondOptions& options, const Callbacks& callbacks) {
    if (options.interfaceTolerance > origin.interfaceTolerance &&
        !columnOfNumbers(pack, kPartColumn))
        callbacks.warn(fmt::format(
            "`interfaceTolerance` {:g} has no effect: the spheres have no column {}, which says "
            "which of several parts each is in; `contactTolerance` is that of all pairs",
            options.interfaceTolerance, kPartColumn));
    if (options.interfaceTolerance > 0 && options.interfaceTolerance < options.tolerance)
        callbacks.warn(fmt::format(
            "`interfaceTolerance` {:g} has no effect: `contactTolerance` {:g} is larger, and bonds "
            "spheres of two parts as well",
            options.interfaceTolerance, options.tolerance));
    if (options.law.modulus != BondLaw().modulus && columnOfNumbers(pack, kModulusColumn))
        callbacks.warn(fmt::format(
            "`bond-modulus` {:g} has no effect: bonds take the moduli in the column {} of their "
            "spheres",
            options.law.modulus, kModulusColumn));
}

void warnOfLostOrigin(const std::vector<OutputTarget>& outputs, const PackOrigin& origin,
                      bool isPeriodic, const Callbacks& callbacks) {
    const auto find = [&](bool isTable) {
        return std::find_if(outputs.begin(), outputs.end(), [&](const OutputTarget& output) {
            return output.kind == OutputKind::pack && (output.extension() == ".csv") == isTable;
        });
    };
    const auto table = find(true);
    if (table == outputs.end() || find(false) != outputs.end()) return;
    std::vector<std::string> lost;
    if (isPeriodic) lost.push_back("the periodic cell (`domain`)");
    if (origin.contactTolerance > StiffnessRecipe().contactTolerance)
        lost.push_back(fmt::format("`contactTolerance` {:g}", origin.contactTolerance));
    if (origin.interfaceTolerance > origin.contactTolerance)
        lost.push_back(fmt::format("`interfaceTolerance` {:g}", origin.interfaceTolerance));
    if (origin.shearRatio > 0) lost.push_back(fmt::format("`bond-shear` {:g}", origin.shearRatio));
    if (!lost.empty())
        callbacks.warn(fmt::format(
            "{}: does not hold {}, with which the pack was made; set the same in runs on this "
            "file, or write .vtp or .vdb",
            table->file, fmt::join(lost, ", ")));
}

template <class Pair>
void warnOfLooseParts(const Pack<3>& pack, const std::vector<Pair>& pairs,
                      const Callbacks& callbacks) {
    const Materials materials(pack);
    if (!materials.hasParts()) return;
    const PartSpace space = spaceOfParts(pack, materials);
    if (space.volume.size() < 2) return;
    auto joined = joinedParts(pack, materials, pairs);
    const std::vector<std::string>& names = partNames(pack);
    const auto nameOf = [&](std::int32_t part) {
        const auto at = static_cast<std::size_t>(part);
        return at < names.size() ? names[at] : fmt::format("part {}", part);
    };
    std::set<std::int32_t> touching;
    for (const auto& [two, sums] : joined)
        if (two.first != two.second) touching.insert({two.first, two.second});
    for (const auto& [two, area] : space.area) {
        touching.insert({two.first, two.second});
        InterfaceReport one{{nameOf(two.first), nameOf(two.second)}, joined[two].pairs, area, {}};
        const std::int32_t ends[] = {two.first, two.second};
        for (std::size_t e = 0; e < 2; ++e)
            one.bulk[e] = joined[{ends[e], ends[e]}].perArea(space.volume.at(ends[e]));
        warnOfWeak(one, two, pack, materials, callbacks);
    }
    for (const auto& [part, volume] : space.volume)
        if (touching.count(part) == 0)
            callbacks.warn(
                fmt::format("{} has no bond that connects it to another part, nor does it lie "
                            "beside one; check "
                            "where it is, or leave it out",
                            nameOf(part)));
}

template void warnOfLooseParts(const Pack<3>&, const std::vector<Bond>&, const Callbacks&);
template void warnOfLooseParts(const Pack<3>&, const std::vector<Contact>&, const Callbacks&);

void measureInterfaces(const Parts& parts, Run<3>& all) {
    if (all.report.interrupted || all.pack.spheres.empty()) return;
    const Materials materials(all.pack);
    auto joined =
        joinedParts(all.pack, materials, bondedPairs(all.pack, bondOptionsOf(all.settings)));
    const auto& outputs = all.settings.outputs;
    const bool bonded = columnOfNumbers(all.pack, kModulusColumn) ||
                        all.settings.bonds.interfaceTolerance > 0 ||
                        std::any_of(outputs.begin(), outputs.end(),
                                    [](const OutputTarget& output) { return output.listsPairs(); });
    std::vector<std::optional<WallPoints>> walls(parts.size());
    for (std::size_t k = 0; k + 1 < parts.size(); ++k) {
        const auto& inner = parts[k].source->mesh();
        std::optional<MeshSides> sides;
        for (std::size_t l = k + 1; l < parts.size(); ++l) {
            const auto& wall = parts[l].source->mesh();
            if (!inner || !wall ||
                intersection(parts[k].source->domainBounds(), parts[l].source->domainBounds())
                    .empty())
                continue;
            if (!sides) sides.emplace(inner, parts[k].source->isWatertight());
            if (!walls[l]) walls[l].emplace(*wall);
            InterfaceReport one;
            one.area = walls[l]->areaIn(*sides);
            if (!(one.area > 0)) continue;
            const auto partAt = [](std::size_t n) { return static_cast<std::int32_t>(n); };
            const PartPair two{partAt(k), partAt(l)};
            one.parts = {parts[k].recipe.name, parts[l].recipe.name};
            one.pairs = joined[two].pairs;
            for (const std::size_t end : {std::size_t(0), std::size_t(1)}) {
                const std::size_t p = end == 0 ? k : l;
                for (const PartReport& part : all.report.parts)
                    if (part.name == parts[p].recipe.name)
                        one.bulk[end] = joined[{partAt(p), partAt(p)}].perArea(part.volume);
            }
            if (bonded) warnOfWeak(one, two, all.pack, materials, all.callbacks);
            all.report.interfaces.push_back(std::move(one));
        }
    }
    for (const Part& part : parts) {
        const auto touches = [&](const InterfaceReport& i) {
            return i.parts[0] == part.recipe.name || i.parts[1] == part.recipe.name;
        };
        const auto& found = all.report.interfaces;
        // Parts that are moved, or of a material of their own, are implants.
        if ((part.recipe.domain.pose.any() || (bonded && !part.recipe.grey.modulus.empty())) &&
            std::none_of(found.begin(), found.end(), touches))
            all.callbacks.warn(part.recipe.name +
                               ": touches no other part where it is; check its place, `translate`, "
                               "`rotate`, `matrix` or `transform`");
    }
}

}  // namespace vdbpack
