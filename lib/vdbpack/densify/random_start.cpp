#include "vdbpack/densify/random_start.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/input_check.h"
#include "vdbpack/pack/front_fraction.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/pack/radius_pool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

/// How far points are moved at random along each axis, in mean radii: or else they stand in rows.
constexpr double kJitter = 2;
/// The least depth of a center, in radii. Walls push spheres inwards; where these would have to lie
/// inside at first, thin places would get too few.
constexpr double kDepth = 0.1;
/// The least depth that a center has after a way inwards, in radii: none in slits.
constexpr double kLeastRoom = 0.95;
/// The largest ball of a domain is found but for this factor.
constexpr double kRoomError = 1.01;
/// Points that are tried at a time, and at most for a sphere.
constexpr std::size_t kPoints = std::size_t{1} << 18, kMostPoints = std::size_t{1} << 24;

/// The points of an additive recurrence, which fill a box evenly at every scale.
/// Source: Roberts (2018), "The Unreasonable Effectiveness of Quasirandom Sequences".
template <int Dim>
class EvenPoints {
public:
    EvenPoints(const Box<Dim>& bounds, std::uint64_t seed) : bounds_(bounds) {
        // Of x^(Dim + 1) = x + 1, the golden ratio in more dimensions.
        constexpr double kRoot = Dim == 3 ? 1.2207440846057596 : 1.3247179572447460;
        RandomStream random(seed, 0);
        double step = 1;
        for (int d = 0; d < Dim; ++d) {
            step_[d] = step /= kRoot;
            share_[d] = random.uniform();
        }
    }
    Vec<Dim> next() {
        Vec<Dim> x = bounds_.lo;
        for (int d = 0; d < Dim; ++d) {
            share_[d] += step_[d];
            share_[d] -= std::floor(share_[d]);
            x[d] += share_[d] * (bounds_.hi[d] - bounds_.lo[d]);
        }
        return x;
    }

private:
    Box<Dim> bounds_;
    Vec<Dim> step_, share_;
};

/// The room at a point: the largest depth on the way from the wall through it, up to `way`, mm.
template <int Dim>
double roomAt(DomainSampler<Dim>& sampler, const Vec<Dim>& x, double depth, double way) {
    constexpr int kParts = 4;
    const double step = 0.05 * way;
    Vec<Dim> inward;
    for (int d = 0; d < Dim; ++d) {
        Vec<Dim> before = x, behind = x;
        before[d] -= step, behind[d] += step;
        inward[d] = sampler.signedDistance(before) - sampler.signedDistance(behind);
    }
    inward = normalized(inward);
    double room = depth;
    for (int k = 1; k <= kParts; ++k)
        room = std::max(room, -sampler.signedDistance(x + inward * (k * way / kParts)));
    return room;
}

}  // namespace

template <int Dim>
std::vector<Sphere<Dim>> randomStart(const Domain<Dim>& domain, const SizeDistribution& sizes,
                                     double volume, double margin, std::uint64_t seed) {
    const double count = volume / sizes.meanBall(Dim);
    if (!(count < 2e9))
        throw ResourceError(
            fmt::format("about {:.3g} {} would be placed, more than 2e9; choose larger sizes",
                        count, Measure<Dim>::kSpheres));
    std::vector<Sphere<Dim>> spheres;
    RadiusPool radii(sizes, seed ^ 0x72616e646f6dull, 0, 1);
    for (double sum = 0; sum < volume; sum += Measure<Dim>::ball(spheres.back().radius))
        spheres.push_back({{}, radii.draw()});
    double largest = 0;
    for (const auto& s : spheres) largest = std::max(largest, s.radius);
    const double room = largestBall(domain).radius - margin;
    if (largest > kRoomError * room)
        throw InputError(
            fmt::format("densify: a {} of radius {:.6g} mm does not fit into the domain, whose "
                        "largest one has {:.6g} mm; choose smaller radii",
                        Measure<Dim>::kSphere, largest, std::max(room, 0.0)));
    EvenPoints<Dim> even(domain.bounds(), seed ^ 0x706c616365ull);
    RandomStream random(seed ^ 0x6a6974746572ull, 0);
    std::size_t placed = 0;
    for (std::size_t tried = 0; placed < spheres.size(); tried += kPoints) {
        if (tried >= kMostPoints)
            throw InputError(fmt::format(
                "densify: of {} random points, none has room for a {} of radius {:.6g} mm; choose "
                "smaller radii",
                tried, Measure<Dim>::kSphere, spheres[placed].radius));
        std::vector<Vec<Dim>> points(kPoints);
        for (Vec<Dim>& x : points) {
            x = even.next();
            for (int d = 0; d < Dim; ++d)
                x[d] += kJitter * sizes.mean() * (2 * random.uniform() - 1);
        }
        std::vector<double> depths = domain.signedDistances(points), rooms(kPoints);
        parallelFor(IndexRange(0, kPoints, 4096), [&](const IndexRange& part) {
            const auto sampler = domain.sampler();
            for (std::size_t k = part.begin(); k < part.end(); ++k) {
                depths[k] = -depths[k];
                if (depths[k] > 0 && depths[k] < largest + margin)
                    rooms[k] = roomAt(*sampler, points[k], depths[k], largest + margin);
                else
                    rooms[k] = depths[k];
            }
        });
        for (std::size_t k = 0; k < kPoints && placed < spheres.size(); ++k) {
            const double radius = spheres[placed].radius;
            if (depths[k] < kDepth * radius + margin || rooms[k] < kLeastRoom * radius + margin)
                continue;
            spheres[placed++].center = points[k];
            tried = 0;
        }
    }
    return spheres;
}

std::vector<double> someRadii(const SizeDistribution& sizes) {
    constexpr std::size_t kSome = 1000;
    std::vector<double> radii(kSome);
    for (std::size_t k = 0; k < kSome; ++k)
        radii[k] = sizes.quantile((static_cast<double>(k) + 0.5) / kSome);
    return radii;
}

template <int Dim>
std::uint64_t aboutCount(const SizeDistribution& sizes, double fraction, double volume) {
    return 1 + static_cast<std::uint64_t>(std::min(fraction, kMostFraction<Dim>) * volume /
                                          sizes.meanBall(Dim));
}

template <int Dim>
double likeFront(const Domain<Dim>& domain, const DensifyOptions& options) {
    return frontFraction<Dim>(options.sizes->mean(), options.sizes->meanBall(Dim),
                              domain.wallArea() / domain.volume(), options.gap);
}

#define VDBPACK_INSTANTIATE(Dim)                                                               \
    template std::vector<Sphere<Dim>> randomStart(const Domain<Dim>&, const SizeDistribution&, \
                                                  double, double, std::uint64_t);              \
    template std::uint64_t aboutCount<Dim>(const SizeDistribution&, double, double);           \
    template double likeFront(const Domain<Dim>&, const DensifyOptions&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
