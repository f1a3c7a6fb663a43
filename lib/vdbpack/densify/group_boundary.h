// Private to densify: the inner face of a shell, which spheres with radii of their own keep to.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/shell_test.h"

#include <cmath>
#include <memory>
#include <optional>

namespace vdbpack {

/// Where the shell ends. Thread-safe.
template <int Dim>
class GroupBoundary {
public:
    /// @param domain, shell  must outlive this.
    GroupBoundary(const Domain<Dim>& domain, const ShellThickness& shell)
        : shell_(shell),
          error_(domain.envelope().facts().voxelSize),
          samplers_([&domain] { return domain.envelope().sampler(); }),
          tests_([&domain, &shell] { return ShellTest<Dim>(domain, shell); }) {}

    /// The end of the shell as seen from a point.
    struct Edge {
        Vec<Dim> inward;       ///< unit direction away from the wall
        double depth = 0;      ///< of the point, mm
        double thickness = 0;  ///< of the shell there, mm
    };
    /// @param inside  whether `x` is to lie below the shell.
    /// @param reach   mm.
    /// @return nothing if it does, or lies within the shell, by more than `reach`.
    std::optional<Edge> edgeNear(const Vec<Dim>& x, bool inside, double reach) {
        DomainSampler<Dim>& sampler = *samplers_.local();
        Edge edge;
        edge.thickness = shell_.at(x);
        const double depth = -sampler.signedDistance(x);
        const double right = inside ? depth - edge.thickness : edge.thickness - depth;
        if (right > reach + error_) return {};
        WallPoint<Dim> wall;
        // One that has got far below the shell is to come back.
        double far = edge.thickness + reach;
        for (int turn = 0; !sampler.nearestWall(x, far, wall); ++turn, far *= 2)
            if (inside || turn == kWidened) return {};
        if (!(wall.distance > 0)) return {};
        edge.inward = (x - wall.point) * (1 / wall.distance);
        edge.depth = wall.distance;
        if ((inside ? 1 : -1) * (edge.depth - edge.thickness) > reach) return {};
        return edge;
    }
    /// Whether `x` lies below the shell.
    bool isDeeper(const Vec<Dim>& x) { return tests_.local().isDeeper(x); }
    /// Whether no wall is closer to `x` than `depth`, mm.
    bool isDeeperThan(const Vec<Dim>& x, double depth) {
        WallPoint<Dim> wall;
        return !samplers_.local()->nearestWall(x, depth, wall);
    }

private:
    /// How often the search for the wall is widened to twice its reach.
    static constexpr int kWidened = 6;

    const ShellThickness& shell_;
    double error_;
    PerThread<std::unique_ptr<DomainSampler<Dim>>> samplers_;
    PerThread<ShellTest<Dim>> tests_;
};

}  // namespace vdbpack
