#include "vdbpack/domain/domain.h"

#include "vdbpack/core/parallel.h"

namespace vdbpack {

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

template class Domain<2>;
template class Domain<3>;

}  // namespace vdbpack
