#include "vdbpack/domain/depth.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/sampling.h"

#include <algorithm>

namespace vdbpack {

template <int Dim>
std::vector<float> centerDepths(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                                const std::vector<double>& toPieces,
                                const std::vector<HalfSpace<Dim>>& clips) {
    Samplers<Dim> samplers(domain);
    std::vector<float> depth(spheres.size());
    parallelFor(IndexRange(0, spheres.size(), 1024), [&](const IndexRange& block) {
        auto& sampler = samplers.local();
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const Vec<Dim>& x = spheres[i].center;
            double distance = -sampler.signedDistance(x);
            if (!toPieces.empty() && distance > 0) {
                distance = toPieces[i];
                for (const auto& clip : clips)
                    distance = std::min(distance,
                                        (clip.offset - dot(clip.normal, x)) / length(clip.normal));
            }
            depth[i] = static_cast<float>(std::max(0.0, distance));
        }
    });
    return depth;
}

template std::vector<float> centerDepths<2>(const std::vector<Sphere<2>>&, const Domain<2>&,
                                            const std::vector<double>&,
                                            const std::vector<HalfSpace<2>>&);
template std::vector<float> centerDepths<3>(const std::vector<Sphere<3>>&, const Domain<3>&,
                                            const std::vector<double>&,
                                            const std::vector<HalfSpace<3>>&);

}  // namespace vdbpack
