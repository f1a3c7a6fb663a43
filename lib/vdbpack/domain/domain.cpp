#include "vdbpack/domain/domain.h"

#include "vdbpack/core/depth_range.h"
#include "vdbpack/core/parallel.h"

namespace vdbpack {

template <int Dim>
DepthRange DomainSampler<Dim>::depthRange(const Vec<Dim>&) {
    return {};
}

template <int Dim>
std::vector<double> Domain<Dim>::signedDistances(const std::vector<Vec<Dim>>& points) const {
    std::vector<double> distances(points.size());
    parallelFor(IndexRange(0, points.size(), 1024), [&](const IndexRange& range) {
        const auto asker = sampler();
        for (std::size_t i = range.begin(); i != range.end(); ++i)
            distances[i] = asker->signedDistance(points[i]);
    });
    return distances;
}

template class DomainSampler<2>;
template class DomainSampler<3>;
template class Domain<2>;
template class Domain<3>;

}  // namespace vdbpack
