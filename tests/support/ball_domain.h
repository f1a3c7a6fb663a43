// Balls whose signed distance is wrong or cut off, as that of a field may be.
#pragma once

#include "vdbpack/domain/analytic_domain.h"

#include <functional>
#include <memory>
#include <utility>

namespace vdbpack::test {

/// A ball about the origin with exact walls, and signed distances that `change` makes of its own.
class ChangedBall : public Domain<3> {
public:
    using Change = std::function<double(double)>;
    ChangedBall(double radius, double fieldDepth, double voxelSize, Change change)
        : ball_(ballDomain<3>(radius)), depth_(fieldDepth), change_(std::move(change)) {
        facts_ = ball_->facts();
        facts_.voxelSize = voxelSize;
    }
    Box<3> bounds() const override { return ball_->bounds(); }
    double volume() const override { return ball_->volume(); }
    double wallArea() const override { return ball_->wallArea(); }
    double volumeDeeperThan(double depth) const override { return ball_->volumeDeeperThan(depth); }
    double fieldDepth() const override { return depth_; }
    DomainFacts facts() const override { return facts_; }
    std::unique_ptr<DomainSampler<3>> sampler() const override {
        struct Sampler : DomainSampler<3> {
            std::unique_ptr<DomainSampler<3>> exact;
            Change change;
            double signedDistance(const Vec<3>& x) override {
                return change(exact->signedDistance(x));
            }
            bool contains(const Vec<3>& x) override { return exact->contains(x); }
            bool nearestWall(const Vec<3>& x, double reach, WallPoint<3>& wall) override {
                return exact->nearestWall(x, reach, wall);
            }
        };
        auto sampler = std::make_unique<Sampler>();
        sampler->exact = ball_->sampler();
        sampler->change = change_;
        return sampler;
    }

private:
    std::shared_ptr<const Domain<3>> ball_;
    double depth_;
    Change change_;
    DomainFacts facts_;
};

}  // namespace vdbpack::test
