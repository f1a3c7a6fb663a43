#include "vdbpack/measure/depth.h"

#include "vdbpack/verify/wall_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

namespace vdbpack {

template <int Dim>
std::vector<float> centerDepths(
    const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
    const std::vector<std::array<Vec<Dim>, static_cast<std::size_t>(Dim)>>& wall,
    const std::vector<HalfSpace<Dim>>& clips) {
    std::optional<WallTree<Dim>> tree;
    if (!wall.empty()) tree.emplace(wall);
    // Beyond this the field is clamped.
    const double clamped = 0.98 * domain.fieldDepth();
    const double slack = domain.facts().voxelSize;
    tbb::enumerable_thread_specific<std::unique_ptr<DomainSampler<Dim>>> samplers(
        [&] { return domain.sampler(); });
    std::vector<float> depth(spheres.size());
    const auto work = [&](const tbb::blocked_range<std::size_t>& range) {
        DomainSampler<Dim>& sampler = *samplers.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const Vec<Dim>& x = spheres[i].center;
            double distance = -sampler.signedDistance(x);
            if (tree) {
                // A search with a bound visits fewer pieces.
                const double guess = std::fabs(distance) + slack;
                const double bound =
                    distance < clamped ? guess * guess : std::numeric_limits<double>::infinity();
                double square = tree->squaredDistance(x, bound);
                if (square >= bound)
                    square = tree->squaredDistance(x, std::numeric_limits<double>::infinity());
                distance = distance > 0 ? std::sqrt(square) : 0;
                for (const auto& clip : clips)
                    distance = std::min(distance,
                                        (clip.offset - dot(clip.normal, x)) / length(clip.normal));
            }
            depth[i] = static_cast<float>(std::max(0.0, distance));
        }
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, spheres.size(), 1024), work);
    return depth;
}

template std::vector<float> centerDepths<2>(const std::vector<Sphere<2>>&, const Domain<2>&,
                                            const std::vector<std::array<Vec<2>, 2>>&,
                                            const std::vector<HalfSpace<2>>&);
template std::vector<float> centerDepths<3>(const std::vector<Sphere<3>>&, const Domain<3>&,
                                            const std::vector<std::array<Vec<3>, 3>>&,
                                            const std::vector<HalfSpace<3>>&);

}  // namespace vdbpack
