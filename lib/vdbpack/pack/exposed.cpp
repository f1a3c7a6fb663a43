#include "vdbpack/pack/exposed.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

/// What one sphere may lie in, itself and copies apart: more makes a front crawl.
constexpr std::size_t kMostAround = 2000;
/// Rounding must not bury a sphere: share of its radius.
constexpr double kMargin = 1e-9;

/// Directions that stand for all within `angle` of them.
template <int Dim>
struct Patches;

template <>
struct Patches<2> {
    static constexpr std::size_t kCount = 36;
    std::vector<Vec<2>> directions;
    double cosine, sine;  ///< of the angle

    Patches() : cosine(std::cos(kPi / kCount)), sine(std::sin(kPi / kCount)) {
        for (std::size_t k = 0; k < kCount; ++k) {
            const double angle = 2 * kPi * static_cast<double>(k) / kCount;
            directions.push_back({{std::cos(angle), std::sin(angle)}});
        }
    }
};

template <>
struct Patches<3> {
    static constexpr std::size_t kAlong = 6;  ///< pieces along each edge of a cube around
    static constexpr std::size_t kCount = 6 * kAlong * kAlong;
    std::vector<Vec<3>> directions;
    double cosine = 1, sine;

    Patches() {
        const auto at = [](int face, double u, double v) {
            Vec<3> x;
            x[face % 3] = face < 3 ? 1 : -1;
            x[(face + 1) % 3] = 2 * u / kAlong - 1;
            x[(face + 2) % 3] = 2 * v / kAlong - 1;
            return normalized(x);
        };
        for (int face = 0; face < 6; ++face)
            for (std::size_t i = 0; i < kAlong; ++i)
                for (std::size_t j = 0; j < kAlong; ++j) {
                    const auto u = static_cast<double>(i), v = static_cast<double>(j);
                    const Vec<3> middle = at(face, u + 0.5, v + 0.5);
                    directions.push_back(middle);
                    // The pieces are convex: their corners are farthest.
                    for (const auto& [du, dv] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}})
                        cosine = std::min(cosine, dot(middle, at(face, u + du, v + dv)));
                }
        sine = std::sqrt(1 - cosine * cosine);
    }
};

/// Larger ones before smaller ones, and else in no order that the input has.
template <int Dim>
auto rank(const std::vector<Sphere<Dim>>& spheres, std::size_t i, std::uint64_t round) {
    return std::make_tuple(-spheres[i].radius, mix64(i + (round << 40)), i);
}

/// Whether those of higher rank hide a sphere. That holds whichever of them are hidden as well,
/// since they are so by others of still higher rank.
template <int Dim>
bool isHidden(const CellLevels<Dim>& cells, const std::vector<Sphere<Dim>>& spheres, std::size_t j,
              double least, std::uint64_t round) {
    static const Patches<Dim> patches;
    const Sphere<Dim>& mine = spheres[j];
    const double grown = mine.radius + least;
    const auto myRank = rank(spheres, j, round);
    std::bitset<Patches<Dim>::kCount> open;
    open.set();
    bool isInside = false;
    cells.forEachNear(mine.center, least, [&](std::uint32_t i, const Sphere<Dim>& other) {
        if (i == j || !(rank(spheres, i, round) < myRank)) return true;
        const Vec<Dim> to = other.center - mine.center;
        const double far2 = squaredLength(to), far = std::sqrt(far2);
        isInside = far + mine.radius <= other.radius;
        if (isInside) return false;
        const double reach = other.radius + least;
        if (!(far < reach * (1 - kMargin))) return true;
        // Points at `grown` in direction w are within it where w * to exceeds this.
        const double above = (grown * grown + far2 - reach * reach) / (2 * grown) + kMargin * grown;
        for (std::size_t k = 0; k < open.size(); ++k) {
            if (!open[k]) continue;
            const double along = dot(patches.directions[k], to);
            const double across = std::sqrt(std::max(0.0, far2 - along * along));
            const double worst = along < -patches.cosine * far
                                     ? -far
                                     : along * patches.cosine - across * patches.sine;
            if (worst > above) open.reset(k);
        }
        return open.any();
    });
    return isInside || open.none();
}

template <int Dim>
void requireUncrowded(const std::vector<Sphere<Dim>>& spheres) {
    const CellLevels<Dim> cells(spheres);
    std::atomic<std::size_t> crowded{spheres.size()};
    forAll(spheres.size(), [&](std::size_t j) {
        std::size_t around = 0;
        cells.forEachNear(spheres[j].center, 0, [&](std::uint32_t i, const Sphere<Dim>& other) {
            around += i != j && other.radius >= spheres[j].radius &&
                      squaredLength(other.center - spheres[j].center) < other.radius * other.radius;
            return around <= kMostAround;
        });
        if (around <= kMostAround) return;
        std::size_t seen = crowded;
        while (j < seen && !crowded.compare_exchange_weak(seen, j)) {
        }
    });
    if (crowded == spheres.size()) return;
    const Sphere<Dim>& s = spheres[crowded];
    std::string at;
    for (int d = 0; d < Dim; ++d) at += fmt::format("{}{:.6g}", d ? ", " : "", s.center[d]);
    throw InputError(fmt::format(
        "existing {}: the one at ({}), radius {:.6g}, has its center in more than {} others; "
        "remove those that lie inside one another",
        Measure<Dim>::kSpheres, at, s.radius, kMostAround));
}

}  // namespace

template <int Dim>
std::vector<Sphere<Dim>> exposedSpheres(std::vector<Sphere<Dim>> spheres, double least) {
    requireUsable(spheres);
    for (std::uint64_t round = 0;; ++round) {
        const std::size_t before = spheres.size();
        const CellLevels<Dim> cells(spheres);
        std::vector<char> hidden(before);
        forAll(before, [&](std::size_t j) {
            hidden[j] = isHidden(cells, spheres, j, least, round) ? 1 : 0;
        });
        std::size_t kept = 0;
        for (std::size_t j = 0; j < before; ++j)
            if (!hidden[j]) spheres[kept++] = spheres[j];
        spheres.resize(kept);
        // Where few ranks are hidden, others hardly are.
        if (before - kept <= before / 16) break;
    }
    requireUncrowded(spheres);
    return spheres;
}

template std::vector<Sphere<2>> exposedSpheres(std::vector<Sphere<2>>, double);
template std::vector<Sphere<3>> exposedSpheres(std::vector<Sphere<3>>, double);

}  // namespace vdbpack
