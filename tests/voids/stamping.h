// Voids by formula, and their exact distances.
#pragma once

#include "support/cube.h"
#include "support/random_point.h"

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

namespace vdbpack {

/// A random direction, not aligned with the axes and not uniform.
template <int Dim>
Vec<Dim> anyDirection(RandomStream& random) {
    return normalized(test::randomPoint(random, test::cube<Dim>(2)));
}

/// Centers in `box`, half-axes b in [least, most], a / b in [flat, lengthy].
template <int Dim>
std::vector<Ellipsoid<Dim>> anyVoids(std::size_t count, const Box<Dim>& box, double least,
                                     double most, double flat, double lengthy, std::uint64_t seed) {
    RandomStream random(seed, Dim);
    std::vector<Ellipsoid<Dim>> voids(count);
    for (auto& e : voids) {
        e.center = test::randomPoint(random, box);
        e.b = least + (most - least) * random.uniform();
        e.a = e.b * (flat + (lengthy - flat) * random.uniform());
        e.axis = anyDirection<Dim>(random);
        e.id = static_cast<std::uint32_t>(&e - voids.data());
    }
    return voids;
}

/// The signed distances to the nearest and to the second nearest of some voids.
template <int Dim>
std::array<double, 2> distancesTo(const std::vector<Ellipsoid<Dim>>& voids, const Vec<Dim>& x) {
    std::array<double, 2> nearest;
    nearest.fill(std::numeric_limits<double>::infinity());
    for (const auto& e : voids) {
        const double d = e.signedDistance(x);
        if (d < nearest[0]) {
            nearest[1] = nearest[0];
            nearest[0] = d;
        } else {
            nearest[1] = std::min(nearest[1], d);
        }
    }
    return nearest;
}

/// Options as a run sets them.
template <int Dim>
StampOptions<Dim> stampOptions(const Domain<Dim>& domain, double voxelSize, double shell = 0) {
    StampOptions<Dim> options;
    options.voxelSize = voxelSize;
    options.origin = fieldOrigin(domain.bounds(), voxelSize);
    options.shell = shell;
    return options;
}

/// Some voids that overlap in a box of side 20, and what stamping them gives.
template <int Dim>
struct Scene {
    std::shared_ptr<const Domain<Dim>> domain = boxDomain<Dim>(test::cube<Dim>(20));
    std::vector<Ellipsoid<Dim>> voids;
    StampOptions<Dim> options;

    explicit Scene(double voxelSize, double shell = 0)
        : voids(anyVoids<Dim>(Dim == 3 ? 120 : 30, test::cube<Dim>(22), 0.8, 2, 0.5, 3, 5)),
          options(stampOptions(*domain, voxelSize, shell)) {}
    std::shared_ptr<const StampedVoids<Dim>> stamp() const {
        return stampVoids(voids, *domain, options);
    }
};

/// Center of the voxel nearest to `x`.
template <int Dim>
Vec<Dim> voxelAt(const Vec<Dim>& x, const StampOptions<Dim>& options) {
    Vec<Dim> center;
    for (int d = 0; d < Dim; ++d)
        center[d] = options.origin[d] +
                    std::round((x[d] - options.origin[d]) / options.voxelSize) * options.voxelSize;
    return center;
}

/// Calls `visit(center)` for all voxels with centers in a box.
template <int Dim, class Visit>
void forEachVoxel(const Box<Dim>& box, const StampOptions<Dim>& options, const Visit& visit) {
    const Vec<Dim> first = voxelAt(box.lo, options);
    std::array<int, 3> count{1, 1, 1}, at{};
    for (int d = 0; d < Dim; ++d)
        count[static_cast<std::size_t>(d)] =
            static_cast<int>(std::round(box.size()[d] / options.voxelSize)) + 1;
    for (at[0] = 0; at[0] < count[0]; ++at[0])
        for (at[1] = 0; at[1] < count[1]; ++at[1])
            for (at[2] = 0; at[2] < count[2]; ++at[2]) {
                Vec<Dim> x = first;
                for (int d = 0; d < Dim; ++d)
                    x[d] += at[static_cast<std::size_t>(d)] * options.voxelSize;
                visit(x);
            }
}

inline Vec<3> centerOf(const VoxelImage& image, std::size_t voxel) {
    const auto nx = static_cast<std::size_t>(image.size[0]);
    const auto ny = static_cast<std::size_t>(image.size[1]);
    return image.origin +
           Vec<3>{{static_cast<double>(voxel % nx), static_cast<double>(voxel / nx % ny),
                   static_cast<double>(voxel / nx / ny)}} *
               image.voxelSize;
}

}  // namespace vdbpack
