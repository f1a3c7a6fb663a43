// Private to densify: the inner face of a shell, which spheres with radii of their own keep to.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/shell_test.h"
#include "vdbpack/domain/shell_thickness.h"

#include <tbb/enumerable_thread_specific.h>

#include <cmath>
#include <memory>

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

    /// @param reach   mm.
    /// @param inward  set to the unit direction away from the wall.
    /// @param below   set to the depth of `x` below the shell, negative within it, mm.
    /// @return whether the shell ends within `reach` of `x`.
    bool isNear(const Vec<Dim>& x, double reach, Vec<Dim>& inward, double& below) {
        DomainSampler<Dim>& sampler = *samplers_.local();
        const double thickness = shell_.at(x);
        const double depth = -sampler.signedDistance(x);
        if (std::fabs(depth - thickness) > reach + error_) return false;
        WallPoint<Dim> wall;
        if (!sampler.nearestWall(x, thickness + reach, wall) || !(wall.distance > 0)) return false;
        inward = (x - wall.point) * (1 / wall.distance);
        below = wall.distance - thickness;
        return below > -reach;
    }

    /// Whether `x` lies below the shell.
    bool isDeeper(const Vec<Dim>& x) { return tests_.local().isDeeper(x); }

private:
    const ShellThickness& shell_;
    double error_;
    tbb::enumerable_thread_specific<std::unique_ptr<DomainSampler<Dim>>> samplers_;
    tbb::enumerable_thread_specific<ShellTest<Dim>> tests_;
};

}  // namespace vdbpack
