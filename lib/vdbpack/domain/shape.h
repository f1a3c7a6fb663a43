// Private: what clipping and slicing need to know of a domain beyond its public face.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>
#include <string>
#include <utility>

namespace vdbpack {

/// A 3D domain that knows its own planar slices.
class Sliceable {
public:
    virtual ~Sliceable() = default;
    /// The plane z = `height` as a domain of (x, y). @throws InputError if the plane misses.
    virtual std::shared_ptr<const Domain<2>> slice(double height) const = 0;
};

/// A convex domain given by a formula.
template <int Dim>
class ConvexShape : public Domain<Dim> {
public:
    /// Where the line parallel to the last axis through `x` (its last component is ignored) runs
    /// deeper than `depth` inside the shape.
    /// @return false if it does not; else `lo` < `hi` are values of the last component, mm.
    virtual bool chord(const Vec<Dim>& x, double depth, double& lo, double& hi) const = 0;
    virtual double signedDistance(const Vec<Dim>& x) const = 0;
    /// The nearest point of the wall from anywhere.
    virtual Vec<Dim> nearestOnWall(const Vec<Dim>& x) const = 0;
    /// The faces closer to `x` than `reach`: the nearest point of each. Where one face is all there
    /// is, and from outside, the nearest of all alone.
    virtual void wallsWithin(const Vec<Dim>& x, double reach,
                             std::vector<WallPoint<Dim>>& points) const;

    double fieldDepth() const override;
    std::unique_ptr<DomainSampler<Dim>> sampler() const override;
    DomainFacts facts() const override;

protected:
    explicit ConvexShape(std::string kind) : kind_(std::move(kind)) {}

private:
    std::string kind_;
};

extern template class ConvexShape<2>;
extern template class ConvexShape<3>;

}  // namespace vdbpack
