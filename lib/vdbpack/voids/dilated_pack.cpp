#include "vdbpack/voids/dilated_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Streams of random numbers, distinct from those of other voids.
constexpr std::uint64_t kFoam = std::uint64_t{5} << 56;
/// Solid fractions that densifying reaches soon and without order, in the plane and in space.
constexpr double kFraction[2] = {0.83, 0.64};
/// Around the box that is asked for: mean radii, and largest radii.
constexpr double kMargin[2] = {4, 2};
constexpr double kExtentStep = 0.06;

/// `x` with its part along `along` times `factor`.
template <int Dim>
Vec<Dim> stretched(const Vec<Dim>& x, const std::optional<Vec<Dim>>& along, double factor) {
    return along ? x + *along * (dot(x, *along) * (factor - 1)) : x;
}

/// The box around a stretched box.
template <int Dim>
Box<Dim> stretched(const Box<Dim>& box, const std::optional<Vec<Dim>>& along, double factor) {
    Box<Dim> around;
    for (unsigned corner = 0; corner < 1u << Dim; ++corner) {
        Vec<Dim> x;
        for (int d = 0; d < Dim; ++d) x[d] = corner >> d & 1 ? box.hi[d] : box.lo[d];
        around.add(stretched(x, along, factor));
    }
    return around;
}

/// A point in the unit ball, or disc.
template <int Dim>
Vec<Dim> inBall(RandomStream& random) {
    for (;;) {
        Vec<Dim> x;
        for (int d = 0; d < Dim; ++d) x[d] = 2 * random.uniform() - 1;
        if (squaredLength(x) <= 1) return x;
    }
}

/// Of the spheres, in mean b: those that are packed as they lie have the volume of their
/// ellipsoids.
template <int Dim>
double meanRadius(const VoidShape<Dim>& shape, const FoamOptions<Dim>& options) {
    return shape.radius.mean() * (options.along ? 1 : std::pow(shape.aspect.mean(), 1.0 / Dim));
}

}  // namespace

template <int Dim>
FoamPack<Dim> foamPack(const SizeDistribution& sizes, const Vec<Dim>& half, std::uint64_t seed,
                       const Callbacks& callbacks, const std::array<bool, Dim>& wraps) {
    FoamPack<Dim> pack;
    pack.wraps = wraps;
    PackOptions front(sizes.scaled(1 / sizes.mean()));
    front.seed = seed;
    front.order = Order::sweep;  // nothing of the front is left once the pack is denser
    Box<Dim> box;
    for (int d = 0; d < Dim; ++d) {
        if (wraps[static_cast<std::size_t>(d)]) {
            pack.half[d] = box.hi[d] = half[d];
        } else {
            pack.half[d] = std::exp(kExtentStep * std::ceil(std::log(half[d]) / kExtentStep));
            // The layers along the walls of the box, where spheres are in order, lie outside.
            box.hi[d] = pack.half[d] + kMargin[0] + kMargin[1] * front.sizes.max();
        }
        box.lo[d] = -box.hi[d];
    }
    const PeriodicCell<Dim> cell{box, wraps};
    if (cell.shortest() < 2 * kCellDiameters * front.sizes.max())
        throw InputError(fmt::format(
            "the periodic cell, compressed along the axis of the foam, is {:.4g} mm long, shorter "
            "than {:g} diameters of {:.4g} mm of the largest voids before their dilation. Give a "
            "longer cell or smaller voids",
            cell.shortest(), kCellDiameters, 2 * front.sizes.max()));
    // Layers along walls lie outside, so that their sizes do not matter.
    front.evenSizes = cell.any();
    const auto room = cell.any() ? periodicDomain(cell) : boxDomain(box);
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    auto packed = packSpheres(*room, front, quiet);
    if (packed.interrupted) throw Interrupted();
    DensifyOptions denser;
    denser.fraction = kFraction[Dim - 2];
    denser.sizes = front.sizes;
    denser.seed = seed;
    denser.contacts = false;  // the fits are those of packs that hardly touch
    auto dense = densify(*room, packed.pack.spheres, denser, quiet);
    if (dense.interrupted) throw Interrupted();
    pack.spheres = std::move(dense.spheres);
    return pack;
}

template <int Dim>
std::optional<Vec<Dim>> compressible(const std::optional<Vec<Dim>>& along,
                                     const PeriodicCell<Dim>& cell) {
    if (!along || !cell.any()) return along;
    int other = 0;
    for (int d = 0; d < Dim; ++d) other += (*along)[d] != 0;
    return other == 1 ? along : std::nullopt;
}

template <int Dim>
Vec<Dim> foamExtent(const VoidRegion<Dim>& region, const VoidShape<Dim>& shape,
                    const FoamOptions<Dim>& options) {
    const Box<Dim> box = stretched(region.domain.bounds(), options.along, 1 / shape.aspect.mean());
    return box.size() * (0.5 / meanRadius(shape, options));
}

template <int Dim>
std::vector<Ellipsoid<Dim>> foamVoids(const VoidRegion<Dim>& region, const FoamPack<Dim>& pack,
                                      const VoidShape<Dim>& shape,
                                      const FoamOptions<Dim>& options) {
    const double stretch = shape.aspect.mean(), scale = meanRadius(shape, options);
    const Box<Dim> bounds = region.domain.bounds();
    std::vector<Ellipsoid<Dim>> voids;
    voids.reserve(pack.spheres.size());
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        RandomStream random(options.seed, kFoam + i);
        const Sphere<Dim> s{pack.spheres[i].center * scale, pack.spheres[i].radius * scale};
        const Vec<Dim> moved = s.center + inBall<Dim>(random) * (options.jitter * s.radius);
        Ellipsoid<Dim> e;
        e.center = bounds.center() + stretched(moved, options.along, stretch);
        const double aspect = shape.aspect.quantile(random.uniform());
        e.b = options.along ? s.radius : s.radius / std::pow(aspect, 1.0 / Dim);
        e.a = e.b * aspect;
        e.id = static_cast<std::uint32_t>(i);
        if (!bounds.grown(kMostDilation * std::max(e.a, e.b)).contains(e.center)) continue;
        e.axis = shape.orientation->axis(e.center, random);
        voids.push_back(e);
    }
    return voids;
}

template <int Dim>
std::vector<Ellipsoid<Dim>> dilated(const VoidRegion<Dim>& region,
                                    std::vector<Ellipsoid<Dim>> voids, double factor,
                                    const std::vector<double>& local) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < voids.size(); ++i) {
        const double by = factor * (local.empty() ? 1 : local[i]);
        if (!local.empty() && local[i] == 0) continue;
        Ellipsoid<Dim>& e = voids[kept++] = voids[i];
        e.a *= by;
        e.b *= by;
    }
    voids.resize(kept);
    keepReaching(region, voids);
    return voids;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template FoamPack<Dim> foamPack<Dim>(const SizeDistribution&, const Vec<Dim>&, std::uint64_t, \
                                         const Callbacks&, const std::array<bool, Dim>&);         \
    template std::optional<Vec<Dim>> compressible(const std::optional<Vec<Dim>>&,                 \
                                                  const PeriodicCell<Dim>&);                      \
    template Vec<Dim> foamExtent(const VoidRegion<Dim>&, const VoidShape<Dim>&,                   \
                                 const FoamOptions<Dim>&);                                        \
    template std::vector<Ellipsoid<Dim>> foamVoids(const VoidRegion<Dim>&, const FoamPack<Dim>&,  \
                                                   const VoidShape<Dim>&,                         \
                                                   const FoamOptions<Dim>&);                      \
    template std::vector<Ellipsoid<Dim>> dilated(                                                 \
        const VoidRegion<Dim>&, std::vector<Ellipsoid<Dim>>, double, const std::vector<double>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
