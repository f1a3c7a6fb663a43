// Private to domain: a convex domain given by a formula.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// A convex domain given by a formula.
template <int Dim>
class ConvexShape : public Domain<Dim> {
public:
    /// The part deeper than `depth` inside the shape of the line through `x` parallel to the last
    /// axis (the last component of `x` is ignored).
    /// @return false if there is none; else `lo` < `hi` are values of the last component, mm.
    virtual bool chord(const Vec<Dim>& x, double depth, double& lo, double& hi) const = 0;
    virtual double signedDistance(const Vec<Dim>& x) const = 0;
    /// The nearest point of the wall from anywhere.
    virtual Vec<Dim> nearestOnWall(const Vec<Dim>& x) const = 0;
    /// Appends the nearest point of every face closer to `x` than `reach`. By default, and from
    /// outside, the nearest point of all alone.
    virtual void wallsWithin(const Vec<Dim>& x, double reach,
                             std::vector<WallPoint<Dim>>& points) const;

    /// All shapes here are as symmetric as their boxes.
    std::optional<Vec<Dim>> centroid() const override { return this->bounds().center(); }
    double fieldDepth() const override;
    std::unique_ptr<DomainSampler<Dim>> sampler() const override;
    DomainFacts facts() const override;

protected:
    explicit ConvexShape(std::string kind) : kind_(std::move(kind)) {}

private:
    std::string kind_;
};

}  // namespace vdbpack
