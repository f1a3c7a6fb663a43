#include "vdbpack/domain/long_axis.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/principal_axes.h"
#include "vdbpack/mesh/mesh_axes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace vdbpack {

namespace {

/// Sums over cells of the share of each that is inside, in an order that does not depend on
/// threads.
template <int Dim>
PrincipalAxes<Dim> axesByCells(const Domain<Dim>& domain) {
    constexpr int kCells = 100;
    const Box<Dim> box = domain.bounds();
    const Vec<Dim> size = box.size();
    const double cell = *std::max_element(size.c.begin(), size.c.end()) / kCells;
    std::array<int, 3> n{1, 1, 1};
    Vec<Dim> step;
    for (int d = 0; d < Dim; ++d) {
        n[static_cast<std::size_t>(d)] = std::max(1, static_cast<int>(std::ceil(size[d] / cell)));
        step[d] = size[d] / n[static_cast<std::size_t>(d)];
    }
    std::vector<SolidMoments<Dim>> rows(static_cast<std::size_t>(n[1] * n[2]));
    parallelFor(std::size_t{0}, rows.size(), [&](std::size_t row) {
        const auto sampler = domain.sampler();
        const std::array<double, 3> at{0, static_cast<double>(row % static_cast<std::size_t>(n[1])),
                                       static_cast<double>(row / static_cast<std::size_t>(n[1]))};
        for (int i = 0; i < n[0]; ++i) {
            Vec<Dim> x = box.lo;
            for (int d = 0; d < Dim; ++d)
                x[d] += (0.5 + (d == 0 ? i : at[static_cast<std::size_t>(d)])) * step[d];
            const double inside = 0.5 - sampler->signedDistance(x) / cell;
            rows[row].add(std::clamp(inside, 0.0, 1.0), x - box.lo);
        }
    });
    SolidMoments<Dim> all;
    for (const auto& row : rows) all.add(row);
    return all.axes(box.lo);
}

}  // namespace

template <int Dim>
Vec<Dim> longAxis(const DomainSource& source, const DomainSource::Built& built) {
    std::optional<PrincipalAxes<Dim>> axes;
    if constexpr (Dim == 3)
        if (source.isWhole() && source.mesh())
            axes = principalAxes(*source.mesh(), analyzeMesh(*source.mesh()));
    if (!axes) axes = axesByCells(*ofDim<Dim>(built));
    if (!axes->isLong())
        throw InputError(source.recipe().source +
                         ": is as wide as it is long, so that it has no long axis; give one as "
                         "X,Y,Z");
    return axes->axes[0];
}

template Vec<2> longAxis<2>(const DomainSource&, const DomainSource::Built&);
template Vec<3> longAxis<3>(const DomainSource&, const DomainSource::Built&);

}  // namespace vdbpack
