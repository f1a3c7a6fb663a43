#include "vdbpack/domain/inset_domain.h"

#include "vdbpack/core/depth_range.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
class InsetSampler : public DomainSampler<Dim> {
public:
    InsetSampler(std::unique_ptr<DomainSampler<Dim>> outer, double inset)
        : outer_(std::move(outer)), inset_(inset) {}

    double signedDistance(const Vec<Dim>& x) override { return outer_->signedDistance(x) + inset_; }

    DepthRange depthRange(const Vec<Dim>& x) override {
        const DepthRange range = outer_->depthRange(x);
        return {range.least - inset_, range.most - inset_};
    }

    bool contains(const Vec<Dim>& x) override {
        return !outer_->isWallCloser(x, inset_) && outer_->contains(x);
    }

    bool isWallCloser(const Vec<Dim>& x, double reach) override {
        return outer_->isWallCloser(x, reach + inset_);
    }

    bool nearestWall(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) override {
        if (!outer_->nearestWall(x, reach + inset_, wall)) return false;
        moveInward(x, wall);
        return true;
    }

    void wallsWithin(const Vec<Dim>& x, double reach,
                     std::vector<WallPoint<Dim>>& points) override {
        std::size_t k = points.size();
        outer_->wallsWithin(x, reach + inset_, points);
        for (; k < points.size(); ++k) moveInward(x, points[k]);
    }

private:
    /// Moves a wall point toward x, or beyond x where x is closer to the wall than the inset.
    void moveInward(const Vec<Dim>& x, WallPoint<Dim>& wall) const {
        if (wall.distance > 0) wall.point += (x - wall.point) * (inset_ / wall.distance);
        wall.distance = std::fabs(wall.distance - inset_);
    }

    std::unique_ptr<DomainSampler<Dim>> outer_;
    double inset_;
};

template <int Dim>
class InsetDomain : public Domain<Dim> {
public:
    InsetDomain(const Domain<Dim>& outer, double inset) : outer_(outer), inset_(inset) {}

    Box<Dim> bounds() const override {
        Box<Dim> box = outer_.bounds();
        const PeriodicCell<Dim> cell = outer_.cell();
        for (int d = 0; d < Dim; ++d) {
            if (cell.isAlong(d)) continue;
            const double by = std::min(inset_, 0.5 * (box.hi[d] - box.lo[d]));
            box.lo[d] += by;
            box.hi[d] -= by;
        }
        return box;
    }
    double volume() const override { return outer_.volume(); }
    double wallArea() const override { return outer_.wallArea(); }
    double volumeDeeperThan(double depth) const override {
        return outer_.volumeDeeperThan(depth + inset_);
    }
    double fieldDepth() const override { return outer_.fieldDepth() - inset_; }
    std::unique_ptr<DomainSampler<Dim>> sampler() const override {
        return std::make_unique<InsetSampler<Dim>>(outer_.sampler(), inset_);
    }
    DomainFacts facts() const override { return outer_.facts(); }
    PeriodicCell<Dim> cell() const override { return outer_.cell(); }

private:
    const Domain<Dim>& outer_;
    double inset_;
};

}  // namespace

template <int Dim>
std::unique_ptr<Domain<Dim>> insetDomain(const Domain<Dim>& domain, double inset) {
    return std::make_unique<InsetDomain<Dim>>(domain, inset);
}

template std::unique_ptr<Domain<2>> insetDomain(const Domain<2>&, double);
template std::unique_ptr<Domain<3>> insetDomain(const Domain<3>&, double);

}  // namespace vdbpack
