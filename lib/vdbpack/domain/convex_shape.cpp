#include "vdbpack/domain/convex_shape.h"

#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

template <int Dim>
class ShapeSampler : public DomainSampler<Dim> {
public:
    explicit ShapeSampler(const ConvexShape<Dim>& shape) : shape_(shape) {}

    double signedDistance(const Vec<Dim>& x) override { return shape_.signedDistance(x); }

    bool nearestWall(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) override {
        const double distance = std::abs(shape_.signedDistance(x));
        if (!(distance < reach)) return false;
        wall.point = shape_.nearestOnWall(x);
        wall.distance = distance;
        return true;
    }

    void wallsWithin(const Vec<Dim>& x, double reach,
                     std::vector<WallPoint<Dim>>& points) override {
        shape_.wallsWithin(x, reach, points);
    }

private:
    const ConvexShape<Dim>& shape_;
};

}  // namespace

template <int Dim>
double ConvexShape<Dim>::fieldDepth() const {
    return std::numeric_limits<double>::infinity();
}

template <int Dim>
void ConvexShape<Dim>::wallsWithin(const Vec<Dim>& x, double reach,
                                   std::vector<WallPoint<Dim>>& points) const {
    const double distance = std::abs(signedDistance(x));
    if (distance < reach) points.push_back({nearestOnWall(x), distance});
}

template <int Dim>
std::unique_ptr<DomainSampler<Dim>> ConvexShape<Dim>::sampler() const {
    return std::make_unique<ShapeSampler<Dim>>(*this);
}

template <int Dim>
DomainFacts ConvexShape<Dim>::facts() const {
    DomainFacts facts;
    facts.kind = kind_;
    return facts;
}

template class ConvexShape<2>;
template class ConvexShape<3>;

}  // namespace vdbpack
