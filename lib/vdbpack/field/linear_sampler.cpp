#include "vdbpack/field/linear_sampler.h"

#include "vdbpack/field/vdb_grid.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

template <int Dim>
struct LinearSampler<Dim>::Impl {
    openvdb::FloatGrid::ConstAccessor accessor;
    Vec<Dim> origin;
    double inverse, outside;
};

template <int Dim>
LinearSampler<Dim>::LinearSampler(const VdbGrid& grid, const Vec<Dim>& origin, double voxelSize,
                                  double outside)
    : impl_(std::make_unique<Impl>(
          Impl{grid.grid->getConstAccessor(), origin, 1 / voxelSize, outside})) {}
template <int Dim>
LinearSampler<Dim>::~LinearSampler() = default;

template <int Dim>
double LinearSampler<Dim>::operator()(const Vec<Dim>& x) {
    std::array<double, Dim> w;
    openvdb::Coord corner(0);
    for (std::size_t d = 0; d < Dim; ++d) {
        const double place = (x.c[d] - impl_->origin.c[d]) * impl_->inverse;
        const double floor = std::floor(place);
        // Far from all voxels, where an index would overflow.
        if (!(std::fabs(floor) < 1e9)) return impl_->outside;
        w[d] = place - floor;
        corner[static_cast<int>(d)] = static_cast<int>(floor);
    }
    double sum = 0;
    for (unsigned n = 0; n < (1u << Dim); ++n) {
        openvdb::Coord at = corner;
        double share = 1;
        for (unsigned d = 0; d < Dim; ++d) {
            const bool upper = (n >> d & 1u) != 0;
            if (upper) ++at[static_cast<int>(d)];
            share *= upper ? w[d] : 1 - w[d];
        }
        sum += share * static_cast<double>(impl_->accessor.getValue(at));
    }
    return sum;
}

template class LinearSampler<2>;
template class LinearSampler<3>;

}  // namespace vdbpack
