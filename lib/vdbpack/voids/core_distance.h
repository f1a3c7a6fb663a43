// Private to stamping: distances to the part of a domain that voids are cut into.
#pragma once

#include "vdbpack/core/depth_range.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/tile_lattice.h"

#include <tbb/concurrent_unordered_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

namespace vdbpack {

/// Exact distances to the core at the voxels of tiles, mm; NaN where they are not known yet.
/// Threads may ask for different tiles at once.
template <int Dim>
class KnownCore {
public:
    using Values = std::array<float, kTileVoxels<Dim>>;

    Values& at(std::uint64_t tile) {
        auto& values = tiles_[tile];
        if (!values) {
            values = std::make_unique<Values>();
            values->fill(std::numeric_limits<float>::quiet_NaN());
        }
        return *values;
    }

private:
    tbb::concurrent_unordered_map<std::uint64_t, std::unique_ptr<Values>> tiles_;
};

/// Distances to the part of the domain deeper than the shell (the core), as accurate as voids need.
template <int Dim>
class CoreDistance {
public:
    CoreDistance(const Domain<Dim>& domain, const StampOptions<Dim>& options)
        : sampler_((options.shell.any() ? domain.envelope() : domain).sampler()),
          domain_(options.shell.any() && &domain.envelope() != &domain ? domain.sampler()
                                                                       : nullptr),
          shell_(options.shell),
          known_(options.core.get()),
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
    /// @param i  voxel of the tile turned to whose center x is.
    double operator()(const Vec<Dim>& x, double toVoid, std::size_t i) {
        const double field = sampler_->signedDistance(x);
        // Where the core's boundary is too far away to matter, any thickness does.
        const bool far =
            field + shell_.most() + error_ < toVoid || field + shell_.least() - error_ > reach_;
        const double shell = far ? shell_.most() : shell_.at(x);
        const double outside = field + shell;
        if (!(shell > 0 && error_ > 0 && toVoid < h_)) return outside;
        if (field <= deepest_) {
            const double reach = shell_.at(x) + kStampBand * h_;
            return exact(x, reach, -kStampBand * h_, i);
        }
        // Where the field's lattice is that of the voids, this is the distance itself.
        const DepthRange depth = sampler_->depthRange(x);
        if (depth.least > shell || depth.most < shell)
            return std::clamp(outside, shell - depth.most, shell - depth.least);
        if (std::fabs(outside) < error_ && field < 0)
            return exact(x, shell_.at(x) + error_, outside, i);
        return outside;
    }
    /// Turns to a tile, of whose voxels distances are asked for next.
    void turnTo(std::uint64_t tile) {
        tile_ = tile;
        values_ = nullptr;
    }

private:
    /// By the exact distance to the wall, if that is within `reach`.
    double exact(const Vec<Dim>& x, double reach, double otherwise, std::size_t i) {
        if (!values_ && known_) values_ = &known_->at(tile_);
        if (values_ && !std::isnan((*values_)[i])) return static_cast<double>((*values_)[i]);
        WallPoint<Dim> wall;
        const double found =
            sampler_->nearestWall(x, reach, wall) ? shell_.at(x) - wall.distance : otherwise;
        if (values_) (*values_)[i] = static_cast<float>(found);
        return found;
    }

    std::unique_ptr<DomainSampler<Dim>> sampler_;  // of what the shell is measured in
    std::unique_ptr<DomainSampler<Dim>> domain_;   // null: the same
    ShellThickness shell_;
    KnownCore<Dim>* known_;  // null: nothing is kept
    std::uint64_t tile_ = 0;
    typename KnownCore<Dim>::Values* values_ = nullptr;  // of the tile; null: not asked for yet
    double h_, reach_, error_, deepest_;
};

}  // namespace vdbpack
