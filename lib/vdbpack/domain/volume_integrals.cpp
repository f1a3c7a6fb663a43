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

/// Sums over rows, in parallel and in an order that does not depend on threads.
/// @param addRow  called as addRow(row, sum). @param scale  of the result.
template <int Dim, class AddRow>
VolumeIntegrals<Dim> sumOverRows(int rows, double scale, const AddRow& addRow) {
    std::vector<VolumeIntegrals<Dim>> sums(static_cast<std::size_t>(rows));
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, 8), [&](const tbb::blocked_range<int>& r) {
        for (int row = r.begin(); row != r.end(); ++row)
            addRow(row, sums[static_cast<std::size_t>(row)]);
    });
    VolumeIntegrals<Dim> all;
    for (const auto& sum : sums) {
        all.volume += sum.volume;
        all.moment += sum.moment;
    }
    return {scale * all.volume, scale * all.moment};
}

/// Adds the chord through `x` along the last axis.
template <int Dim>
void addChord(const ConvexShape<Dim>& shape, const std::vector<HalfSpace<Dim>>& planes,
              double depth, Vec<Dim> x, VolumeIntegrals<Dim>& sum) {
    double lo = 0, hi = 0;
    if (!shape.chord(x, depth, lo, hi)) return;
    for (const auto& plane : planes) {
        double rest = plane.offset;
        for (int i = 0; i + 1 < Dim; ++i) rest -= plane.normal[i] * x[i];
        const double slope = plane.normal[Dim - 1];
        if (slope > 0)
            hi = std::min(hi, rest / slope);
        else if (slope < 0)
            lo = std::max(lo, rest / slope);
        else if (rest < 0)
            return;
    }
    x[Dim - 1] = 0.5 * (lo + hi);
    sum.add(std::max(0.0, hi - lo), x);
}

}  // namespace

template <int Dim>
VolumeIntegrals<Dim> integralsByChords(const ConvexShape<Dim>& shape,
                                       const std::vector<HalfSpace<Dim>>& planes, double depth,
                                       const Box<Dim>& box) {
    if (box.empty() || !(box.volume() > 0)) return {};
    const int n = Dim == 3 ? kChordsPerAxis3D : kChords2D;
    const Vec<Dim> step = box.size() * (1.0 / n);
    const double across = Dim == 3 ? step[0] * step[1] : step[0];
    return sumOverRows<Dim>(n, across, [&](int row, VolumeIntegrals<Dim>& sum) {
        Vec<Dim> x;
        x[Dim - 2] = box.lo[Dim - 2] + (row + 0.5) * step[Dim - 2];
        for (int i = 0; i < (Dim == 3 ? n : 1); ++i) {
            if (Dim == 3) x[0] = box.lo[0] + (i + 0.5) * step[0];
            addChord<Dim>(shape, planes, depth, x, sum);
        }
    });
}

template <int Dim>
VolumeIntegrals<Dim> integralsBySamples(
    const Box<Dim>& box, double voxelSize, double depth,
    const std::function<std::unique_ptr<DomainSampler<Dim>>()>& sampler) {
    if (box.empty() || !(box.volume() > 0)) return {};
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
    return sumOverRows<Dim>(n[last], cellVolume, [&](int row, VolumeIntegrals<Dim>& sum) {
        const auto asker = sampler();
        Vec<Dim> x;
        x[Dim - 1] = box.lo[Dim - 1] + (row + 0.5) * step[Dim - 1];
        const int middle = Dim == 3 ? n[1] : 1;
        for (int j = 0; j < middle; ++j) {
            if (Dim == 3) x[1] = box.lo[1] + (j + 0.5) * step[1];
            for (int i = 0; i < n[0]; ++i) {
                x[0] = box.lo[0] + (i + 0.5) * step[0];
                const double outward = asker->signedDistance(x) + depth;
                sum.add(std::clamp(0.5 - outward / width, 0.0, 1.0), x);
            }
        }
    });
}

template <int Dim>
double wallAreaByVolumes(const Domain<Dim>& domain, double step) {
    return (3 * domain.volume() - 4 * domain.volumeDeeperThan(step) +
            domain.volumeDeeperThan(2 * step)) /
           (2 * step);
}

#define VDBPACK_INSTANTIATE(Dim)                                                               \
    template VolumeIntegrals<Dim> integralsByChords(                                           \
        const ConvexShape<Dim>&, const std::vector<HalfSpace<Dim>>&, double, const Box<Dim>&); \
    template VolumeIntegrals<Dim> integralsBySamples(                                          \
        const Box<Dim>&, double, double,                                                       \
        const std::function<std::unique_ptr<DomainSampler<Dim>>()>&);                          \
    template double wallAreaByVolumes(const Domain<Dim>&, double);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
