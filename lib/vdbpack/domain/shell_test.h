// Whether points lie deeper than the shell along the wall of a domain.
#pragma once

#include "vdbpack/domain/domain.h"

#include <cmath>
#include <memory>

namespace vdbpack {

/// Tests points against the shell of a domain from one thread.
template <int Dim>
class ShellTest {
public:
    /// @param domain, shell  must outlive this; depths are those below the wall of its envelope.
    ShellTest(const Domain<Dim>& domain, const ShellThickness& shell)
        : shell_(shell),
          error_(domain.envelope().facts().voxelSize),
          sampler_(domain.envelope().sampler()) {}

    /// By the signed distance field, and by the exact distance to the wall where the field is too
    /// coarse to decide.
    bool isDeeper(const Vec<Dim>& x) {
        const double depth = -sampler_->signedDistance(x);
        const double thickness = shell_.at(x);
        WallPoint<Dim> wall;
        if (error_ > 0 && depth > 0 && std::fabs(depth - thickness) < error_)
            return !sampler_->nearestWall(x, thickness, wall);
        return depth > thickness;
    }
    /// Depth by the field, mm, and how far that may be off.
    double depth(const Vec<Dim>& x) { return -sampler_->signedDistance(x); }
    double error() const { return error_; }

private:
    const ShellThickness& shell_;
    double error_;
    std::unique_ptr<DomainSampler<Dim>> sampler_;
};

}  // namespace vdbpack
