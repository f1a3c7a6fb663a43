#include "vdbpack/voids/dilated_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"

#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Streams of random numbers, distinct from those of other voids.
constexpr std::uint64_t kFoam = std::uint64_t{5} << 56;
/// Solid fractions that densifying reaches soon and without order, in the plane and in space.
constexpr double kFraction[2] = {0.83, 0.64};

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

}  // namespace

template <int Dim>
std::vector<Ellipsoid<Dim>> foamVoids(const VoidRegion<Dim>& region, const VoidShape<Dim>& shape,
                                      const FoamOptions<Dim>& options, const Callbacks& callbacks) {
    const double stretch = shape.aspect.mean();
    // Of the spheres, in b: those that are packed as they lie have the volume of their ellipsoids.
    const double radius = options.along ? 1 : std::pow(stretch, 1.0 / Dim);
    PackOptions front(shape.radius.scaled(radius));
    front.seed = options.seed;
    // The layers along the walls of the box, where spheres are in order, lie outside of the domain.
    const Box<Dim> box =
        stretched(region.domain.bounds(), options.along, 1 / stretch).grown(4 * front.sizes.max());
    const auto room = boxDomain(box);
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    auto packed = packSpheres(*room, front, quiet);
    if (packed.interrupted) throw Interrupted();
    DensifyOptions denser;
    denser.fraction = kFraction[Dim - 2];
    denser.sizes = front.sizes;
    denser.seed = options.seed;
    auto dense = densify(*room, packed.pack.spheres, denser, quiet);
    if (dense.interrupted) throw Interrupted();
    std::vector<Ellipsoid<Dim>> voids(dense.spheres.size());
    for (std::size_t i = 0; i < voids.size(); ++i) {
        RandomStream random(options.seed, kFoam + i);
        const Sphere<Dim>& s = dense.spheres[i];
        const Vec<Dim> moved = s.center + inBall<Dim>(random) * (options.jitter * s.radius);
        Ellipsoid<Dim>& e = voids[i];
        e.center = stretched(moved, options.along, stretch);
        const double aspect = shape.aspect.quantile(random.uniform());
        e.b = options.along ? s.radius : s.radius / std::pow(aspect, 1.0 / Dim);
        e.a = e.b * aspect;
        e.axis = shape.orientation->axis(e.center, random);
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
    template std::vector<Ellipsoid<Dim>> foamVoids(const VoidRegion<Dim>&, const VoidShape<Dim>&, \
                                                   const FoamOptions<Dim>&, const Callbacks&);    \
    template std::vector<Ellipsoid<Dim>> dilated(                                                 \
        const VoidRegion<Dim>&, std::vector<Ellipsoid<Dim>>, double, const std::vector<double>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
