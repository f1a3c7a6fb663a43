#include "vdbpack/domain/volume_integrals.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace vdbpack {

namespace {

// Numbers of lines and samples.
constexpr int kChordsPerAxis3D = 1400;
constexpr int kChords2D = 200000;
constexpr double kMostSamples = 1.2e7;

/// Sums `rowSum(row)` over rows, in parallel and in an order that does not depend on threads.
template <class RowSum>
double sumOverRows(int rows, const RowSum& rowSum) {
    std::vector<double> sums(static_cast<std::size_t>(rows));
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, 8), [&](const tbb::blocked_range<int>& r) {
        for (int row = r.begin(); row != r.end(); ++row)
            sums[static_cast<std::size_t>(row)] = rowSum(row);
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// Length of the chord through `x` along the last axis.
template <int Dim>
double chordLength(const ConvexShape<Dim>& shape, const std::vector<HalfSpace<Dim>>& planes,
                   double depth, const Vec<Dim>& x) {
    double lo = 0, hi = 0;
    if (!shape.chord(x, depth, lo, hi)) return 0.0;
    for (const auto& plane : planes) {
        double rest = plane.offset;
        for (int i = 0; i + 1 < Dim; ++i) rest -= plane.normal[i] * x[i];
        const double slope = plane.normal[Dim - 1];
        if (slope > 0)
            hi = std::min(hi, rest / slope);
        else if (slope < 0)
            lo = std::max(lo, rest / slope);
        else if (rest < 0)
            return 0.0;
    }
    return std::max(0.0, hi - lo);
}

}  // namespace

template <int Dim>
double volumeByChords(const ConvexShape<Dim>& shape, const std::vector<HalfSpace<Dim>>& planes,
                      double depth, const Box<Dim>& box) {
    if (box.empty() || !(box.volume() > 0)) return 0;
    const int n = Dim == 3 ? kChordsPerAxis3D : kChords2D;
    const Vec<Dim> step = box.size() * (1.0 / n);
    if constexpr (Dim == 2) {
        return step[0] * sumOverRows(n, [&](int row) {
                   return chordLength<2>(shape, planes, depth,
                                         {{box.lo[0] + (row + 0.5) * step[0], 0}});
               });
    } else {
        return step[0] * step[1] * sumOverRows(n, [&](int row) {
                   double sum = 0;
                   for (int i = 0; i < n; ++i)
                       sum += chordLength<3>(shape, planes, depth,
                                             {{box.lo[0] + (i + 0.5) * step[0],
                                               box.lo[1] + (row + 0.5) * step[1], 0}});
                   return sum;
               });
    }
}

template <int Dim>
double volumeBySamples(const Box<Dim>& box, double voxelSize, double depth,
                       const std::function<std::unique_ptr<DomainSampler<Dim>>()>& sampler) {
    if (box.empty() || !(box.volume() > 0)) return 0;
    const Vec<Dim> size = box.size();
    const double finest = std::pow(box.volume() / kMostSamples, 1.0 / Dim);
    const double cell = Dim == 3 ? std::max(finest, 0.5 * voxelSize) : finest;
    std::array<int, Dim> n{};
    Vec<Dim> step;
    double width = 0;
    for (int i = 0; i < Dim; ++i) {
        n[static_cast<std::size_t>(i)] = std::max(1, static_cast<int>(std::ceil(size[i] / cell)));
        step[i] = size[i] / n[static_cast<std::size_t>(i)];
        width = std::max(width, step[i]);
    }
    const std::size_t last = static_cast<std::size_t>(Dim - 1);
    const double cellVolume =
        box.volume() / std::accumulate(n.begin(), n.end(), 1.0, std::multiplies<double>());
    return cellVolume * sumOverRows(n[last], [&](int row) {
               const auto asker = sampler();
               double sum = 0;
               Vec<Dim> x;
               x[Dim - 1] = box.lo[Dim - 1] + (row + 0.5) * step[Dim - 1];
               const int middle = Dim == 3 ? n[1] : 1;
               for (int j = 0; j < middle; ++j) {
                   if (Dim == 3) x[1] = box.lo[1] + (j + 0.5) * step[1];
                   for (int i = 0; i < n[0]; ++i) {
                       x[0] = box.lo[0] + (i + 0.5) * step[0];
                       const double outward = asker->signedDistance(x) + depth;
                       sum += std::clamp(0.5 - outward / width, 0.0, 1.0);
                   }
               }
               return sum;
           });
}

template <int Dim>
double wallAreaByVolumes(const Domain<Dim>& domain, double step) {
    return (3 * domain.volume() - 4 * domain.volumeDeeperThan(step) +
            domain.volumeDeeperThan(2 * step)) /
           (2 * step);
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template double volumeByChords(const ConvexShape<Dim>&, const std::vector<HalfSpace<Dim>>&,   \
                                   double, const Box<Dim>&);                                      \
    template double volumeBySamples(const Box<Dim>&, double, double,                              \
                                    const std::function<std::unique_ptr<DomainSampler<Dim>>()>&); \
    template double wallAreaByVolumes(const Domain<Dim>&, double);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
