#include "vdbpack/voids/cull.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/shell_test.h"

#include <cmath>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

template <class Body>
void forRanges(std::size_t n, const Body& body) {
    parallelFor(IndexRange(0, n, 2048), body);
}

template <class T>
void keepValues(std::vector<T>& values, const std::vector<std::uint8_t>& keep) {
    if (values.empty()) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < keep.size(); ++i)
        if (keep[i]) {
            if (kept != i) values[kept] = std::move(values[i]);
            ++kept;
        }
    values.resize(kept);
}

}  // namespace

template <int Dim>
std::vector<std::uint8_t> spheresOutside(const std::vector<Sphere<Dim>>& spheres,
                                         const StampedVoids<Dim>& voids, Cull cull) {
    std::vector<std::uint8_t> keep(spheres.size());
    forRanges(spheres.size(), [&](const IndexRange& range) {
        typename StampedVoids<Dim>::Sampler distance(voids);
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            keep[i] =
                distance(spheres[i].center) >= (cull == Cull::touch ? spheres[i].radius : 0.0);
    });
    return keep;
}

template <int Dim>
std::vector<std::uint8_t> centersOutside(const std::vector<Sphere<Dim>>& spheres,
                                         const std::vector<Ellipsoid<Dim>>& voids,
                                         const StampedVoids<Dim>& stamped,
                                         const std::vector<std::int32_t>& deep) {
    const double close = stamped.voxelSize();
    std::vector<std::uint8_t> keep(spheres.size());
    forRanges(spheres.size(), [&](const IndexRange& range) {
        typename StampedVoids<Dim>::Sampler distanceAt(stamped);
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const double distance = distanceAt(spheres[i].center);
            const bool within =
                std::fabs(distance) < close ? stamped.isIn(voids, spheres[i].center) : distance < 0;
            keep[i] = !(deep[i] && within);
        }
    });
    return keep;
}

template <int Dim>
std::vector<std::int32_t> deeperThan(const std::vector<Sphere<Dim>>& spheres,
                                     const Domain<Dim>& domain, const ShellThickness& shell) {
    std::vector<std::int32_t> deep(spheres.size(), 1);
    if (!shell.any()) return deep;
    forRanges(spheres.size(), [&](const IndexRange& range) {
        ShellTest<Dim> test(domain, shell);
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            deep[i] = test.isDeeper(spheres[i].center);
    });
    return deep;
}

template <int Dim>
void keepOnly(Pack<Dim>& pack, const std::vector<std::uint8_t>& keep) {
    forEachAttribute(pack, [&keep](std::string_view, auto& values) { keepValues(values, keep); });
    keepValues(pack.spheres, keep);
}

#define VDBPACK_INSTANTIATE(Dim)                                                              \
    template std::vector<std::uint8_t> spheresOutside(const std::vector<Sphere<Dim>>&,        \
                                                      const StampedVoids<Dim>&, Cull);        \
    template std::vector<std::uint8_t> centersOutside(                                        \
        const std::vector<Sphere<Dim>>&, const std::vector<Ellipsoid<Dim>>&,                  \
        const StampedVoids<Dim>&, const std::vector<std::int32_t>&);                          \
    template std::vector<std::int32_t> deeperThan(const std::vector<Sphere<Dim>>&,            \
                                                  const Domain<Dim>&, const ShellThickness&); \
    template void keepOnly(Pack<Dim>&, const std::vector<std::uint8_t>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
