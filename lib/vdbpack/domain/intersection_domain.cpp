#include "vdbpack/domain/intersection_domain.h"

#include "vdbpack/core/depth_range.h"
#include "vdbpack/domain/volume_integrals.h"

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
    std::optional<Vec<Dim>> centroid() const override { return inner_->centroid(); }
    double wallArea() const override { return inner_->wallArea(); }
    double volumeDeeperThan(double depth) const override { return inner_->volumeDeeperThan(depth); }
    double fieldDepth() const override {
        return std::min(inner_->fieldDepth(), outer_->fieldDepth());
    }
    std::unique_ptr<DomainSampler<Dim>> sampler() const override {
        return std::make_unique<IntersectionSampler<Dim>>(inner_->sampler(), outer_->sampler());
    }
    DomainFacts facts() const override { return inner_->facts(); }

protected:
    std::shared_ptr<const Domain<Dim>> inner_, outer_;
};

class PartDomain : public IntersectionDomain<3> {
public:
    using IntersectionDomain<3>::IntersectionDomain;
    const Domain<3>& envelope() const override { return outer_->envelope(); }
};

class CutDomain : public IntersectionDomain<3> {
public:
    CutDomain(std::shared_ptr<const Domain<3>> base, std::shared_ptr<const Domain<3>> outside,
              bool fromBase)
        : IntersectionDomain(std::move(base), std::move(outside)),
          fromBase_(fromBase),
          whole_(partDeeperThan(0)) {}

    Box<3> bounds() const override { return inner_->bounds(); }
    double volume() const override { return whole_.volume; }
    std::optional<Vec<3>> centroid() const override { return whole_.centroid(); }
    double wallArea() const override {
        const double voxel = std::max(inner_->facts().voxelSize, outer_->facts().voxelSize);
        const Vec<3> size = bounds().size();
        const double step =
            voxel > 0 ? voxel : 0.01 * *std::min_element(size.c.begin(), size.c.end());
        return wallAreaByVolumes(*this, step);
    }
    double volumeDeeperThan(double depth) const override { return partDeeperThan(depth).volume; }

    const Domain<3>& envelope() const override {
        return fromBase_ ? inner_->envelope() : static_cast<const Domain<3>&>(*this);
    }

private:
    VolumeIntegrals<3> partDeeperThan(double depth) const {
        return integralsBySamples<3>(bounds(), inner_->facts().voxelSize, depth,
                                     [this] { return sampler(); });
    }

    bool fromBase_;
    VolumeIntegrals<3> whole_;
};

}  // namespace

template <int Dim>
std::shared_ptr<const Domain<Dim>> intersectionDomain(std::shared_ptr<const Domain<Dim>> inner,
                                                      std::shared_ptr<const Domain<Dim>> outer) {
    return std::make_shared<IntersectionDomain<Dim>>(std::move(inner), std::move(outer));
}

std::shared_ptr<const Domain<3>> partDomain(std::shared_ptr<const Domain<3>> inner,
                                            std::shared_ptr<const Domain<3>> outer) {
    return std::make_shared<PartDomain>(std::move(inner), std::move(outer));
}

std::shared_ptr<const Domain<3>> cutDomain(std::shared_ptr<const Domain<3>> base,
                                           std::shared_ptr<const Domain<3>> outside,
                                           bool fromBase) {
    return std::make_shared<CutDomain>(std::move(base), std::move(outside), fromBase);
}

template std::shared_ptr<const Domain<2>> intersectionDomain(std::shared_ptr<const Domain<2>>,
                                                             std::shared_ptr<const Domain<2>>);
template std::shared_ptr<const Domain<3>> intersectionDomain(std::shared_ptr<const Domain<3>>,
                                                             std::shared_ptr<const Domain<3>>);

}  // namespace vdbpack
