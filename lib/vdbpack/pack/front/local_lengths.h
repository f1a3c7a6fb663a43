// The lengths of a front where the requested sizes differ by place.
#pragma once

#include "vdbpack/pack/front/front_settings.h"
#include "vdbpack/pack/local_sizes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace vdbpack {

/// Sizes that are requested at points of a domain, and the lengths that follow from them. Of one
/// thread.
template <int Dim>
class LocalLengths {
public:
    /// @param groups  lengths of each group of sizes where the factor is 1.
    /// @param layer   by which spheres are grown, mm.
    LocalLengths(const Domain<Dim>& domain, const LocalSizes& sizes,
                 std::vector<FrontLengths> groups, double layer)
        : sampler_(domain, sizes), groups_(std::move(groups)), layer_(layer) {}

    LocalSize at(const Vec<Dim>& x) { return sampler_.at(x); }
    FrontLengths of(const LocalSize& size) const {
        return groups_[size.group].scaled(size.factor, layer_, Dim);
    }
    double layer() const { return layer_; }

    /// Of a block: the lengths of the finest sizes, with the largest radius of the coarsest.
    FrontLengths over(const Box<Dim>& box) { return joined(sampler_.within(box)); }

    /// Of the sites on a sphere. Where other sizes begin at about its surface, those of the coarser
    /// ones are sought as well.
    /// @param leastMean  set to the least mean radius that is requested up to `kRoom` of its own
    ///                   mean radii from its surface, mm.
    FrontLengths ofPivot(const Vec<Dim>& x, double radius, double& leastMean) {
        const LocalSize size = at(x);
        FrontLengths own = of(size);
        const auto all = sampler_.around(x, radius + kRoom * own.meanRadius);
        leastMean = meanOf(all);
        // Nearly the same sizes everywhere there.
        if (all.inner != all.shell && all.most <= kJump * all.least) return own;
        const auto range = sampler_.around(x, kBeside * radius);
        const bool other = size.group == 0 ? range.shell : range.inner && groups_.size() > 1;
        if (!other && range.most <= kJump * size.factor) return own;
        for (std::uint32_t g = 0; g < groups_.size(); ++g) {
            if (g != size.group && !other) continue;
            const FrontLengths coarse = of({range.most, g});
            if (!(coarse.maxRadius > own.maxRadius)) continue;
            own.maxRadius = coarse.maxRadius;
            own.reach = coarse.reach;
        }
        return own;
    }

    /// The least mean radius that is requested within a distance of a point, mm.
    double leastMean(const Vec<Dim>& x, double distance) {
        return meanOf(sampler_.around(x, distance));
    }
    /// The mean radius that is requested at a point, mm.
    double mean(const Vec<Dim>& x) {
        const LocalSize size = at(x);
        return (groups_[size.group].meanRadius - layer_) * size.factor + layer_;
    }
    /// As in `LocalSizeSampler`.
    bool isConstant(const Vec<Dim>& x, double distance) { return sampler_.isConstant(x, distance); }
    /// See `ofPivot`.
    static constexpr double kRoom = 1.02;

    /// Whether two requests are nearly the same, so that one sphere may serve either.
    static bool areAlike(const LocalSize& a, const LocalSize& b) {
        return a.group == b.group && std::fabs(a.factor - b.factor) <= kAlike * a.factor;
    }

private:
    /// Distance from a pivot's center up to which other sizes matter, in its radii, and how much
    /// larger they are there.
    static constexpr double kBeside = 1.5, kJump = 1.5;
    static constexpr double kAlike = 0.1;

    double meanOf(const typename LocalSizeSampler<Dim>::Range& range) const {
        double least = 0;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            if (!(g == 0 ? range.inner || !range.shell : range.shell)) continue;
            const double mean = (groups_[g].meanRadius - layer_) * range.least + layer_;
            least = least > 0 ? std::min(least, mean) : mean;
        }
        return least;
    }
    FrontLengths joined(const typename LocalSizeSampler<Dim>::Range& range) const {
        FrontLengths all;
        for (std::uint32_t g = 0; g < groups_.size(); ++g) {
            if (!(g == 0 ? range.inner || !range.shell : range.shell)) continue;
            const double most = std::max(all.maxRadius, of({range.most, g}).maxRadius);
            const FrontLengths fine = of({range.least, g});
            if (!(all.meanRadius > 0) || fine.meanRadius < all.meanRadius) all = fine;
            all.maxRadius = most;
        }
        all.maxRadius *= 1 + 1e-6;  // radii are rounded to floats
        return all;
    }

    LocalSizeSampler<Dim> sampler_;
    std::vector<FrontLengths> groups_;
    double layer_;
};

}  // namespace vdbpack
