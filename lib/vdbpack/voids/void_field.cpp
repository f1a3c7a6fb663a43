#include "vdbpack/voids/void_field.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/core_volume.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Streams of random numbers, distinct from those of packs.
constexpr std::uint64_t kCenters = std::uint64_t{1} << 56, kBoxes = std::uint64_t{2} << 56,
                        kShapes = std::uint64_t{3} << 56, kOrder = std::uint64_t{4} << 56;
/// Voids per parallel task.
constexpr std::size_t kBatch = 4096;

template <int Dim>
void keepMarked(const std::vector<std::uint8_t>& marked, std::vector<Ellipsoid<Dim>>& voids) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < voids.size(); ++i)
        if (marked[i]) voids[kept++] = voids[i];
    voids.resize(kept);
}

/// The largest ellipsoid of revolution with its axes along the sides of a box.
template <int Dim>
Ellipsoid<Dim> inscribed(const Vec<Dim>& sides) {
    Ellipsoid<Dim> best;
    for (int along = 0; along < Dim; ++along) {
        double across = std::numeric_limits<double>::infinity();
        for (int d = 0; d < Dim; ++d)
            if (d != along) across = std::min(across, sides[d]);
        Ellipsoid<Dim> e;
        e.a = 0.5 * sides[along];
        e.b = 0.5 * across;
        e.axis[along] = 1;
        if (e.volume() > best.volume() * (1 + 1e-12)) best = e;
    }
    return best;
}

}  // namespace

template <int Dim>
void keepReaching(const VoidRegion<Dim>& region, std::vector<Ellipsoid<Dim>>& voids) {
    std::vector<std::uint8_t> reaches(voids.size());
    parallelFor(IndexRange(0, voids.size(), kBatch), [&](const IndexRange& range) {
        const auto sampler = region.domain.envelope().sampler();
        const double error = region.domain.facts().voxelSize;
        WallPoint<Dim> wall;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const auto& e = voids[i];
            const double reach = std::max(e.a, e.b) - region.shell.least();
            const double outside = sampler->signedDistance(e.center);
            reaches[i] = outside < reach;
            // A field ends close to the wall: farther out, ask the wall.
            if (reaches[i] && outside > error && error > 0)
                reaches[i] = sampler->nearestWall(e.center, reach, wall);
        }
    });
    keepMarked(reaches, voids);
}

template <int Dim>
double VoidRegion<Dim>::volume() const {
    return coreVolume(domain, shell);
}

template <int Dim>
double VoidShape<Dim>::meanMeasure() const {
    // a b^(Dim-1) = aspect b^Dim, drawn independently.
    return aspect.mean() * radius.meanBall(Dim);
}

template <int Dim>
std::vector<Ellipsoid<Dim>> booleanVoids(const VoidRegion<Dim>& region, const VoidShape<Dim>& shape,
                                         std::uint64_t seed, double density,
                                         const std::function<double(const Vec<Dim>&)>& share) {
    const PeriodicCell<Dim> cell = region.domain.cell();
    Box<Dim> window = region.domain.bounds().grown(shape.reach());
    for (int d = 0; d < Dim; ++d)
        if (cell.isAlong(d)) window.lo[d] = cell.box.lo[d], window.hi[d] = cell.box.hi[d];
    const double expected = density * window.volume();
    if (!(expected < 4e9))
        throw ResourceError(fmt::format(
            "{:.3g} voids would have to be drawn; choose fewer or larger ones", expected));
    const auto drawn = static_cast<std::size_t>(std::llround(expected));
    std::vector<Ellipsoid<Dim>> voids, batch;
    std::vector<std::uint8_t> kept(share ? 256 * kBatch : 0);
    // In parts, since most of the box around a bone is empty.
    for (std::size_t first = 0; first < drawn; first += 256 * kBatch) {
        batch.resize(std::min<std::size_t>(256 * kBatch, drawn - first));
        parallelFor(IndexRange(0, batch.size(), kBatch), [&](const IndexRange& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                RandomStream random(seed, kCenters + first + i);
                Ellipsoid<Dim>& e = batch[i];
                for (int d = 0; d < Dim; ++d)
                    e.center[d] = window.lo[d] + random.uniform() * window.size()[d];
                e.b = shape.radius.quantile(random.uniform());
                e.a = e.b * shape.aspect.quantile(random.uniform());
                e.axis = shape.orientation->axis(e.center, random);
                e.id = static_cast<std::uint32_t>(first + i);
                if (share) kept[i] = random.uniform() < share(e.center);
            }
        });
        if (share) keepMarked(kept, batch);
        keepReaching(region, batch);
        voids.insert(voids.end(), batch.begin(), batch.end());
    }
    return voids;
}

template <int Dim>
VoidLattice<Dim> voidLattice(const Box<Dim>& bounds, const std::vector<double>& cell,
                             const VoidMatrix* matrix, const std::array<bool, Dim>& wraps) {
    VoidLattice<Dim> lattice;
    const Vec<Dim> size = bounds.size();
    if (cell.empty()) {
        lattice.origin = bounds.lo;
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            // One layer is used for all.
            if (Dim == 3 && d == 2 && matrix->size[2] == 1) {
                lattice.cell[2] = std::min(lattice.cell[0], lattice.cell[1]);
                lattice.count[2] =
                    std::max<std::int64_t>(1, std::llround(size[2] / lattice.cell[2]));
            } else {
                lattice.count[at] = matrix->size[at];
            }
            lattice.cell[d] = size[d] / static_cast<double>(lattice.count[at]);
        }
        return lattice;
    }
    const auto given = fmt::format("`cell` {}", fmt::join(cell, ","));
    const bool good = std::all_of(cell.begin(), cell.end(),
                                  [](double side) { return side > 0 && std::isfinite(side); });
    if (!good || (cell.size() != 1 && cell.size() != Dim))
        throw ParameterError(fmt::format("{}: write the side of a box in mm, or {} in mm", given,
                                         Dim == 3 ? "X,Y,Z" : "X,Y"));
    std::vector<double> sides = cell;
    if (sides.size() == 1) sides.assign(Dim, cell[0]);
    double boxes = 1;
    for (int d = 0; d < Dim; ++d) {
        const auto i = static_cast<std::size_t>(d);
        const double whole =
            wraps[i] ? std::round(size[d] / sides[i]) : std::ceil(size[d] / sides[i] * (1 - 1e-9));
        const double n = std::max(1.0, whole);
        if (wraps[i]) sides[i] = size[d] / n;
        boxes *= n;
        if (!(boxes < 4e9))
            throw ResourceError(given + ": makes more than 4e9 boxes; choose larger ones");
        lattice.count[i] = static_cast<std::int64_t>(n);
        lattice.cell[d] = sides[i];
        lattice.origin[d] = bounds.center()[d] - 0.5 * n * sides[i];
    }
    return lattice;
}

template <int Dim>
std::vector<Ellipsoid<Dim>> latticeVoids(const VoidRegion<Dim>& region,
                                         const VoidLattice<Dim>& lattice, const VoidMatrix* matrix,
                                         double probability, std::uint64_t seed) {
    Ellipsoid<Dim> e = inscribed(lattice.cell);
    std::vector<Ellipsoid<Dim>> voids;
    std::uint64_t number = 0;
    std::array<std::int64_t, 3> at{};
    for (at[0] = 0; at[0] < lattice.count[0]; ++at[0])
        for (at[1] = 0; at[1] < lattice.count[1]; ++at[1])
            for (at[2] = 0; at[2] < lattice.count[2]; ++at[2], ++number) {
                if (matrix && !matrix->at(static_cast<int>(at[0] % matrix->size[0]),
                                          static_cast<int>(at[1] % matrix->size[1]),
                                          static_cast<int>(at[2] % matrix->size[2])))
                    continue;
                if (RandomStream(seed, kBoxes + number).uniform() >= probability) continue;
                for (int d = 0; d < Dim; ++d)
                    e.center[d] = lattice.origin[d] +
                                  (static_cast<double>(at[static_cast<std::size_t>(d)]) + 0.5) *
                                      lattice.cell[d];
                e.id = static_cast<std::uint32_t>(number);
                voids.push_back(e);
            }
    keepReaching(region, voids);
    return voids;
}

template <int Dim>
std::vector<Ellipsoid<Dim>> voidsAtSpheres(const std::vector<Sphere<Dim>>& spheres, bool inside,
                                           const VoidShape<Dim>& shape, std::uint64_t seed) {
    std::vector<Ellipsoid<Dim>> voids(spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        RandomStream random(seed, kShapes + i);
        const double aspect = shape.aspect.quantile(random.uniform());
        Ellipsoid<Dim>& e = voids[i];
        e.center = spheres[i].center;
        e.b = inside ? spheres[i].radius / std::max(1.0, aspect) : spheres[i].radius;
        e.a = e.b * aspect;
        e.axis = shape.orientation->axis(e.center, random);
        e.id = static_cast<std::uint32_t>(i);
    }
    return voids;
}

template <int Dim>
void shuffle(std::vector<Ellipsoid<Dim>>& voids, std::uint64_t seed) {
    RandomStream random(seed, kOrder);
    for (std::size_t n = voids.size(); n > 1; --n) {
        const auto pick = static_cast<std::size_t>(random.uniform() * static_cast<double>(n));
        std::swap(voids[n - 1], voids[pick]);
    }
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template struct VoidShape<Dim>;                                                               \
    template struct VoidRegion<Dim>;                                                              \
    template void keepReaching(const VoidRegion<Dim>&, std::vector<Ellipsoid<Dim>>&);             \
    template std::vector<Ellipsoid<Dim>> booleanVoids(                                            \
        const VoidRegion<Dim>&, const VoidShape<Dim>&, std::uint64_t, double,                     \
        const std::function<double(const Vec<Dim>&)>&);                                           \
    template VoidLattice<Dim> voidLattice<Dim>(const Box<Dim>&, const std::vector<double>&,       \
                                               const VoidMatrix*, const std::array<bool, Dim>&);  \
    template std::vector<Ellipsoid<Dim>> latticeVoids(const VoidRegion<Dim>&,                     \
                                                      const VoidLattice<Dim>&, const VoidMatrix*, \
                                                      double, std::uint64_t);                     \
    template std::vector<Ellipsoid<Dim>> voidsAtSpheres(const std::vector<Sphere<Dim>>&, bool,    \
                                                        const VoidShape<Dim>&, std::uint64_t);    \
    template void shuffle(std::vector<Ellipsoid<Dim>>&, std::uint64_t);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
