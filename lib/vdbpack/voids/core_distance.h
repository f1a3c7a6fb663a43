// Private to stamping: distances to the part of a domain that voids are cut into.
#pragma once

#include "vdbpack/core/depth_range.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/tile_lattice.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace vdbpack {

/// Distances to the part of the domain deeper than the shell (the core), as accurate as voids need.
template <int Dim>
class CoreDistance {
public:
    CoreDistance(const Domain<Dim>& domain, const StampOptions<Dim>& options)
        : sampler_((options.shell.any() ? domain.envelope() : domain).sampler()),
          domain_(options.shell.any() && &domain.envelope() != &domain ? domain.sampler()
                                                                       : nullptr),
          shell_(options.shell),
          h_(options.voxelSize),
          reach_(std::max(kStampBand * options.voxelSize, options.reach)),
          error_(domain.facts().voxelSize),
          deepest_(-domain.fieldDepth() * (1 - 1e-9)) {}

    /// Locates the ball of `radius` about `middle` relative to the core.
    /// @param inside   no void is cut deeper than this inside the core, mm.
    /// @param outside  distances farther outside of the core are not needed, mm.
    /// @param apart    set to whether the ball lies farther outside.
    /// @param cut      set to whether the boundary of the core may meet the ball.
    void look(const Vec<Dim>& middle, double radius, double inside, double outside, bool& apart,
              bool& cut) {
        const double field = sampler_->signedDistance(middle);
        const bool deep = field <= deepest_;
        apart = !deep && field + shell_.least() - radius - error_ > outside;
        // Below the field, ask the wall.
        cut = deep ? sampler_->isWallCloser(middle, shell_.most() + radius + inside)
                   : field + shell_.most() + radius + error_ > -inside;
        if (domain_) cut |= domain_->signedDistance(middle) + radius + error_ > 0;
    }
    /// Whether a point that the shell encloses is in the domain, and not in one of its cavities.
    bool inDomain(const Vec<Dim>& x) { return !domain_ || domain_->signedDistance(x) < 0; }
    /// Distance to the core, negative inside; by the exact distance to the wall below the field,
    /// and where a void may come closer to the wall than the field can resolve.
    double operator()(const Vec<Dim>& x, double toVoid) {
        const double field = sampler_->signedDistance(x);
        // Where the core's boundary is too far away to matter, any thickness does.
        const bool far =
            field + shell_.most() + error_ < toVoid || field + shell_.least() - error_ > reach_;
        const double shell = far ? shell_.most() : shell_.at(x);
        const double outside = field + shell;
        if (!(shell > 0 && error_ > 0 && toVoid < h_)) return outside;
        WallPoint<Dim> wall;
        if (field <= deepest_) {
            const double reach = shell + kStampBand * h_;
            return shell - (sampler_->nearestWall(x, reach, wall) ? wall.distance : reach);
        }
        // Where the field's lattice is that of the voids, this is the distance itself.
        const DepthRange depth = sampler_->depthRange(x);
        if (depth.least > shell || depth.most < shell)
            return std::clamp(outside, shell - depth.most, shell - depth.least);
        if (std::fabs(outside) < error_ && field < 0 &&
            sampler_->nearestWall(x, shell + error_, wall))
            return shell - wall.distance;
        return outside;
    }

private:
    std::unique_ptr<DomainSampler<Dim>> sampler_;  // of what the shell is measured in
    std::unique_ptr<DomainSampler<Dim>> domain_;   // null: the same
    ShellThickness shell_;
    double h_, reach_, error_, deepest_;
};

}  // namespace vdbpack
