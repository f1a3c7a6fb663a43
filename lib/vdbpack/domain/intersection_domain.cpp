#include "vdbpack/domain/intersection_domain.h"

#include <algorithm>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
class IntersectionSampler : public DomainSampler<Dim> {
public:
    IntersectionSampler(std::unique_ptr<DomainSampler<Dim>> inner,
                        std::unique_ptr<DomainSampler<Dim>> outer)
        : inner_(std::move(inner)), outer_(std::move(outer)) {}

    double signedDistance(const Vec<Dim>& x) override {
        return std::max(inner_->signedDistance(x), outer_->signedDistance(x));
    }

    DepthRange depthRange(const Vec<Dim>& x) override {
        const DepthRange a = inner_->depthRange(x), b = outer_->depthRange(x);
        return {std::min(a.least, b.least), std::min(a.most, b.most)};
    }

    bool contains(const Vec<Dim>& x) override { return inner_->contains(x) && outer_->contains(x); }

    bool nearestWall(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) override {
        const bool found = inner_->nearestWall(x, reach, wall);
        return outer_->nearestWall(x, found ? wall.distance : reach, wall) || found;
    }

    void wallsWithin(const Vec<Dim>& x, double reach,
                     std::vector<WallPoint<Dim>>& points) override {
        inner_->wallsWithin(x, reach, points);
        outer_->wallsWithin(x, reach, points);
    }

    bool isWallCloser(const Vec<Dim>& x, double reach) override {
        return inner_->isWallCloser(x, reach) || outer_->isWallCloser(x, reach);
    }

private:
    std::unique_ptr<DomainSampler<Dim>> inner_, outer_;
};

template <int Dim>
class IntersectionDomain : public Domain<Dim> {
public:
    IntersectionDomain(std::shared_ptr<const Domain<Dim>> inner,
                       std::shared_ptr<const Domain<Dim>> outer)
        : inner_(std::move(inner)), outer_(std::move(outer)) {}

    Box<Dim> bounds() const override { return intersection(inner_->bounds(), outer_->bounds()); }
    double volume() const override { return inner_->volume(); }
    double wallArea() const override { return inner_->wallArea(); }
    double volumeDeeperThan(double depth) const override { return inner_->volumeDeeperThan(depth); }
    double fieldDepth() const override {
        return std::min(inner_->fieldDepth(), outer_->fieldDepth());
    }
    std::unique_ptr<DomainSampler<Dim>> sampler() const override {
        return std::make_unique<IntersectionSampler<Dim>>(inner_->sampler(), outer_->sampler());
    }
    DomainFacts facts() const override { return inner_->facts(); }

private:
    std::shared_ptr<const Domain<Dim>> inner_, outer_;
};

}  // namespace

template <int Dim>
std::shared_ptr<const Domain<Dim>> intersectionDomain(std::shared_ptr<const Domain<Dim>> inner,
                                                      std::shared_ptr<const Domain<Dim>> outer) {
    return std::make_shared<IntersectionDomain<Dim>>(std::move(inner), std::move(outer));
}

template std::shared_ptr<const Domain<2>> intersectionDomain(std::shared_ptr<const Domain<2>>,
                                                             std::shared_ptr<const Domain<2>>);
template std::shared_ptr<const Domain<3>> intersectionDomain(std::shared_ptr<const Domain<3>>,
                                                             std::shared_ptr<const Domain<3>>);

}  // namespace vdbpack
