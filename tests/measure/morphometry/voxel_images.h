// Voxel images of solids given by formulas.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/field/voxel_image.h"

#include <catch2/catch.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdbpack::test {

/// `n` voxels a side about the origin, from the signed distance `f(x)` in mm, clamped at three
/// voxels as a level set is. `margin`: layers of voxels that are no part of the total volume.
template <class F>
VoxelImage voxelImage(std::int64_t n, double voxelSize, const F& f, std::int64_t margin = 0) {
    VoxelImage image;
    image.size = {n, n, n};
    image.voxelSize = voxelSize;
    for (int i = 0; i < 3; ++i) image.origin[i] = -0.5 * static_cast<double>(n - 1) * voxelSize;
    image.distance.resize(image.voxels());
    if (margin > 0) image.label.assign(image.voxels(), 0);
    tbb::parallel_for(std::int64_t{0}, n, [&](std::int64_t z) {
        for (std::int64_t y = 0; y < n; ++y)
            for (std::int64_t x = 0; x < n; ++x) {
                const auto voxel = static_cast<std::size_t>((z * n + y) * n + x);
                const Vec<3> at =
                    image.origin + Vec<3>{{static_cast<double>(x), static_cast<double>(y),
                                           static_cast<double>(z)}} *
                                       voxelSize;
                image.distance[voxel] =
                    static_cast<float>(std::clamp(f(at), -3 * voxelSize, 3 * voxelSize));
                const std::int64_t rim = std::min({x, y, z, n - 1 - x, n - 1 - y, n - 1 - z});
                if (margin > 0 && rim >= margin) image.label[voxel] = 1;
            }
    });
    return image;
}

/// A direction of a fixed random stream.
inline Vec<3> randomDirection(RandomStream& random) {
    const double z = 2 * random.uniform() - 1;
    const double phi = 2 * kPi * random.uniform();
    const double r = std::sqrt(1 - z * z);
    return {{r * std::cos(phi), r * std::sin(phi), z}};
}

/// Two unit vectors at right angles to `u` and to each other.
inline std::array<Vec<3>, 2> across(const Vec<3>& u) {
    const Vec<3> e =
        normalized(cross(u, std::abs(u[0]) < 0.9 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}}));
    return {e, cross(u, e)};
}

/// Slabs of `width` across `normal`, `period` apart.
struct Slabs {
    Vec<3> normal;
    double width, period, offset;
    double operator()(const Vec<3>& x) const {
        const double s = dot(x, normal) + offset;
        return std::abs(s - period * std::round(s / period)) - width / 2;
    }
};

/// Round rods of `width` along `axis` on a square lattice.
struct Rods {
    Vec<3> axis;
    double width, period;
    std::array<double, 2> offset;
    double operator()(const Vec<3>& x) const {
        const auto directions = across(axis);
        double square = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            double s = dot(x, directions[i]) + offset[i];
            s -= period * std::round(s / period);
            square += s * s;
        }
        return std::sqrt(square) - width / 2;
    }
};

/// What is left of space by ellipsoidal voids at random places (a Boolean model), voxel by voxel.
struct Voids {
    std::array<double, 3> semiAxes{};  ///< mm, the longest first
    double perVolume = 0;              ///< 1/mm³
    double stretch = 1;  ///< of the directions of the longest axes along z; 1: all alike
    std::uint64_t seed = 1;

    double volume() const { return 4.0 / 3.0 * kPi * semiAxes[0] * semiAxes[1] * semiAxes[2]; }
};

inline VoxelImage voidsImage(std::int64_t n, double voxelSize, const Voids& voids) {
    // Distances to the ellipsoids to first order, which is what counts at their surface.
    const auto far = static_cast<float>(3 * voxelSize);
    VoxelImage image = voxelImage(n, voxelSize, [&](const Vec<3>&) { return -1e30; });
    const double side = static_cast<double>(n) * voxelSize, rim = voids.semiAxes[0];
    const auto count =
        static_cast<std::int64_t>(std::lround(voids.perVolume * std::pow(side + 2 * rim, 3)));
    RandomStream random(voids.seed, 1);
    for (std::int64_t i = 0; i < count; ++i) {
        Vec<3> center;
        for (int j = 0; j < 3; ++j) center[j] = (side + 2 * rim) * (random.uniform() - 0.5);
        Vec<3> u = randomDirection(random);
        u[2] *= voids.stretch;
        u = normalized(u);
        const double turn = 2 * kPi * random.uniform();
        const auto [e, g] = across(u);
        const Vec<3> axes[3] = {u, e * std::cos(turn) + g * std::sin(turn),
                                g * std::cos(turn) - e * std::sin(turn)};
        std::array<std::int64_t, 3> lo{}, hi{};
        for (int j = 0; j < 3; ++j) {
            const auto axis = static_cast<std::size_t>(j);
            const double at = (center[j] - image.origin[j]) / voxelSize;
            const double reach = rim / voxelSize + 3;
            lo[axis] = std::max<std::int64_t>(0, std::llround(at - reach));
            hi[axis] = std::min<std::int64_t>(n - 1, std::llround(at + reach));
        }
        for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
            for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
                for (std::int64_t x = lo[0]; x <= hi[0]; ++x) {
                    const Vec<3> p = image.origin +
                                     Vec<3>{{static_cast<double>(x), static_cast<double>(y),
                                             static_cast<double>(z)}} *
                                         voxelSize -
                                     center;
                    double level = 0, slope = 0;
                    for (std::size_t j = 0; j < 3; ++j) {
                        const double q = dot(p, axes[j]) / voids.semiAxes[j];
                        level += q * q;
                        slope += q * q / (voids.semiAxes[j] * voids.semiAxes[j]);
                    }
                    level = std::sqrt(level);
                    const double d = slope > 0 ? level * (level - 1) / std::sqrt(slope) : -1e30;
                    float& value = image.distance[static_cast<std::size_t>((z * n + y) * n + x)];
                    value = std::max(value, std::min(static_cast<float>(-d), far));
                }
    }
    return image;
}

/// Relative tolerance alone.
inline Approx within(double value, double share) {
    return Approx(value).epsilon(share).margin(0);
}

/// A solid like trabecular bone: BV/TV 0.15, longer along z.
inline Voids trabecular() {
    Voids voids;
    voids.semiAxes = {0.32, 0.25, 0.21};
    voids.perVolume = -std::log(0.15) / voids.volume();
    voids.stretch = 3;
    voids.seed = 5;
    return voids;
}

}  // namespace vdbpack::test
