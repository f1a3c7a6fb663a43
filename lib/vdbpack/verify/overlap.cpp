#include "vdbpack/verify/overlap.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/verify/repeated.h"
#include "vdbpack/verify/sphere_cells.h"
#include "vdbpack/verify/usable.h"
#include "vdbpack/verify/worst.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

namespace vdbpack {

namespace {

bool worse(const OverlapPair& a, const OverlapPair& b) {
    return std::make_tuple(-a.overlap, a.i, a.j) < std::make_tuple(-b.overlap, b.i, b.j);
}

/// @param numbered  `numbered(i, a, j, b, pair)`: whether a pair counts; sets its indices.
template <int Dim, class Numbered>
OverlapCheck countOverlaps(const std::vector<Sphere<Dim>>& spheres, const Numbered& numbered) {
    struct Found {
        OverlapCheck check;
        std::uint64_t sinceShared = 0;
    };
    const std::uint64_t limit = 200 * static_cast<std::uint64_t>(spheres.size()) + 1000000;
    std::atomic<std::uint64_t> shared{0};
    PerThread<Found> found;
    const SphereClasses<Dim> classes(spheres);
    classes.forEachOverlap(
        [&](std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j, const Sphere<Dim>& b,
            double square) {
            OverlapPair pair;
            if (!numbered(i, a, j, b, pair)) return;
            const double overlap =
                (a.radius + b.radius - std::sqrt(square)) / std::min(a.radius, b.radius);
            Found& mine = found.local();
            mine.check.max = std::max(mine.check.max, overlap);
            if (!(overlap > kVerifyTolerance)) return;
            ++mine.check.pairs;
            if (++mine.sinceShared == 4096) {
                shared += mine.sinceShared;
                mine.sinceShared = 0;
            }
            pair.overlap = overlap;
            keepWorst(mine.check.worst, pair, worse);
        },
        [&] { return shared.load(std::memory_order_relaxed) > limit; });
    OverlapCheck result;
    for (const Found& f : found) {
        result.max = std::max(result.max, f.check.max);
        result.pairs += f.check.pairs;
        for (const auto& w : f.check.worst) keepWorst(result.worst, w, worse);
    }
    result.complete = shared <= limit;
    return result;
}

}  // namespace

template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres, std::size_t own) {
    requireVerifiable(spheres);
    return countOverlaps(spheres, [own](std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j,
                                        const Sphere<Dim>& b, OverlapPair& pair) {
        pair.i = std::min(i, j);
        pair.j = std::max(i, j);
        return pair.j < own || (isBefore(a, b) ? i : j) < own;  // else it counts in another part
    });
}

template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell) {
    if (!cell.any()) return checkOverlap(spheres);
    requireVerifiable(spheres);
    const RepeatedSpheres<Dim> all = repeatedSpheres(spheres, cell);
    const std::size_t own = spheres.size();
    return countOverlaps(all.spheres, [&](std::uint32_t i, const Sphere<Dim>&, std::uint32_t j,
                                          const Sphere<Dim>&, OverlapPair& pair) {
        const std::size_t a = all.original[i], b = all.original[j];
        pair.i = std::min(a, b);
        pair.j = std::max(a, b);
        // Across a face a pair is found from both sides.
        if (i < own && j < own) return true;
        if (i >= own && j >= own) return false;
        return (i < own ? a : b) == pair.i;
    });
}

template OverlapCheck checkOverlap<2>(const std::vector<Sphere<2>>&, std::size_t);
template OverlapCheck checkOverlap<3>(const std::vector<Sphere<3>>&, std::size_t);
template OverlapCheck checkOverlap<2>(const std::vector<Sphere<2>>&, const PeriodicCell<2>&);
template OverlapCheck checkOverlap<3>(const std::vector<Sphere<3>>&, const PeriodicCell<3>&);

}  // namespace vdbpack
