#include "vdbpack/verify/overlap.h"

#include "vdbpack/verify/sphere_cells.h"
#include "vdbpack/verify/usable.h"
#include "vdbpack/verify/worst.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

namespace vdbpack {

namespace {

bool worse(const OverlapPair& a, const OverlapPair& b) {
    return std::make_tuple(-a.overlap, a.i, a.j) < std::make_tuple(-b.overlap, b.i, b.j);
}

}  // namespace

template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres, std::size_t own) {
    requireVerifiable(spheres);
    struct Found {
        OverlapCheck check;
        std::uint64_t sinceShared = 0;
    };
    const std::uint64_t limit = 200 * static_cast<std::uint64_t>(spheres.size()) + 1000000;
    std::atomic<std::uint64_t> shared{0};
    tbb::enumerable_thread_specific<Found> found;
    const SphereClasses<Dim> classes(spheres);
    classes.forEachOverlap(
        [&](std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j, const Sphere<Dim>& b,
            double square) {
            if (std::max(i, j) >= own && (isBefore(a, b) ? i : j) >= own) return;  // counts there
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
            const OverlapPair pair{std::min(i, j), std::max(i, j), overlap};
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

template OverlapCheck checkOverlap<2>(const std::vector<Sphere<2>>&, std::size_t);
template OverlapCheck checkOverlap<3>(const std::vector<Sphere<3>>&, std::size_t);

}  // namespace vdbpack
