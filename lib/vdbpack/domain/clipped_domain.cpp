#include "vdbpack/domain/clipped_domain.h"

#include "vdbpack/core/depth_range.h"
#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/box_planes.h"
#include "vdbpack/domain/convex_shape.h"
#include "vdbpack/domain/volume_integrals.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
std::vector<HalfSpace<Dim>> moved(std::vector<HalfSpace<Dim>> planes, double inward) {
    for (auto& plane : planes) plane.offset -= inward;
    return planes;
}

template <int Dim>
class ClippedSampler : public DomainSampler<Dim> {
public:
    ClippedSampler(std::unique_ptr<DomainSampler<Dim>> base,
                   const std::vector<HalfSpace<Dim>>& planes)
        : base_(std::move(base)), planes_(planes) {}

    double signedDistance(const Vec<Dim>& x) override {
        double distance = base_->signedDistance(x);
        for (const auto& plane : planes_)
            distance = std::max(distance, dot(plane.normal, x) - plane.offset);
        return distance;
    }

    DepthRange depthRange(const Vec<Dim>& x) override {
        DepthRange range = base_->depthRange(x);
        for (const auto& plane : planes_) {
            const double depth = plane.offset - dot(plane.normal, x);
            range.least = std::min(range.least, depth);
            range.most = std::min(range.most, depth);
        }
        // Outside, the wall can be farther away than each part's.
        if (range.least < 0) range.least = -std::numeric_limits<double>::infinity();
        return range;
    }

    bool contains(const Vec<Dim>& x) override {
        for (const auto& plane : planes_)
            if (dot(plane.normal, x) >= plane.offset) return false;
        return base_->contains(x);
    }

    // The complement of an intersection is the union of complements, so from inside the nearest
    // of the parts' walls is the nearest wall.
    bool nearestWall(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) override {
        bool found = base_->nearestWall(x, reach, wall);
        if (found) reach = wall.distance;
        for (const auto& plane : planes_) {
            const double height = dot(plane.normal, x) - plane.offset;
            if (!(std::abs(height) < reach)) continue;
            reach = std::abs(height);
            wall.point = x - plane.normal * height;
            wall.distance = reach;
            found = true;
        }
        return found;
    }

    void wallsWithin(const Vec<Dim>& x, double reach,
                     std::vector<WallPoint<Dim>>& points) override {
        base_->wallsWithin(x, reach, points);
        for (const auto& plane : planes_) {
            const double height = dot(plane.normal, x) - plane.offset;
            if (std::abs(height) < reach)
                points.push_back({x - plane.normal * height, std::abs(height)});
        }
    }

private:
    std::unique_ptr<DomainSampler<Dim>> base_;
    const std::vector<HalfSpace<Dim>>& planes_;
};

template <int Dim>
class ClippedDomain : public Domain<Dim> {
public:
    ClippedDomain(std::shared_ptr<const Domain<Dim>> base, std::vector<HalfSpace<Dim>> planes,
                  std::shared_ptr<const Domain<Dim>> envelope)
        : base_(std::move(base)),
          envelope_(std::move(envelope)),
          convex_(dynamic_cast<const ConvexShape<Dim>*>(base_.get())),
          planes_(std::move(planes)),
          bounds_(cutBounds(base_->bounds(), planes_)),
          whole_(partDeeperThan(0)) {}

    const std::shared_ptr<const Domain<Dim>>& base() const { return base_; }
    const std::vector<HalfSpace<Dim>>& planes() const { return planes_; }

    Box<Dim> bounds() const override { return bounds_; }
    double volume() const override { return whole_.volume; }
    std::optional<Vec<Dim>> centroid() const override { return whole_.centroid(); }

    double wallArea() const override {
        const Vec<Dim> size = bounds_.size();
        double step = size[0];
        for (int i = 1; i < Dim; ++i) step = std::min(step, size[i]);
        step *= 0.01;
        const double voxel = base_->facts().voxelSize;
        if (voxel > 0) step = std::clamp(step, 0.5 * voxel, 0.4 * base_->fieldDepth());
        return wallAreaByVolumes(*this, step);
    }

    double volumeDeeperThan(double depth) const override { return partDeeperThan(depth).volume; }

    double fieldDepth() const override { return base_->fieldDepth(); }
    std::unique_ptr<DomainSampler<Dim>> sampler() const override {
        return std::make_unique<ClippedSampler<Dim>>(base_->sampler(), planes_);
    }
    DomainFacts facts() const override { return base_->facts(); }
    const Domain<Dim>& envelope() const override {
        return envelope_ ? *envelope_ : static_cast<const Domain<Dim>&>(*this);
    }

protected:
    std::shared_ptr<const Domain<Dim>> base_, envelope_;  // no envelope: the domain itself

private:
    VolumeIntegrals<Dim> partDeeperThan(double depth) const {
        if (convex_ == nullptr)
            return integralsBySamples<Dim>(bounds_, base_->facts().voxelSize, depth,
                                           [this] { return sampler(); });
        const auto planes = moved(planes_, depth);
        return integralsByChords(*convex_, planes, depth,
                                 cutBounds(base_->bounds().grown(-depth), planes));
    }

    const ConvexShape<Dim>* convex_;
    std::vector<HalfSpace<Dim>> planes_;
    Box<Dim> bounds_;
    VolumeIntegrals<Dim> whole_;
};

class SliceableClipped : public ClippedDomain<3>, public Sliceable {
public:
    using ClippedDomain<3>::ClippedDomain;
    std::shared_ptr<const Domain<2>> slice(double height) const override {
        std::vector<HalfSpace<2>> lines;
        for (const auto& plane : planes()) {
            const HalfSpace<2> line{{{plane.normal[0], plane.normal[1]}},
                                    plane.offset - plane.normal[2] * height};
            if (length(line.normal) > 1e-12) {
                lines.push_back(line);
            } else if (line.offset < 0) {
                throw InputError(
                    fmt::format("slice z={}: nothing of the domain is left at this height after "
                                "clipping; choose another height or clip less",
                                height));
            }
        }
        const auto slice = sliceDomain(base(), height);
        auto envelope = envelope_ ? sliceDomain(envelope_, height) : nullptr;
        return lines.empty() ? slice : clippedDomain<2>(slice, lines, std::move(envelope));
    }
};

/// Half-spaces with normals of length one.
template <int Dim>
std::vector<HalfSpace<Dim>> unitNormals(const std::vector<HalfSpace<Dim>>& planes) {
    std::vector<HalfSpace<Dim>> unit;
    for (const auto& plane : planes) {
        const double scale = length(plane.normal);
        if (!(scale > 0) || !std::isfinite(scale) || !std::isfinite(plane.offset))
            throw ParameterError(
                "clip: a plane needs a finite normal other than zero and a finite offset; write "
                "it as plane:nx,ny,nz,d");
        unit.push_back({plane.normal * (1 / scale), plane.offset / scale});
    }
    return unit;
}

/// Cuts a box by the half-spaces that lie along its axes. @return whether all do.
template <int Dim>
bool cutAlongAxes(const std::vector<HalfSpace<Dim>>& planes, Box<Dim>& box) {
    bool all = true;
    for (const auto& plane : planes) {
        int axis = -1;
        for (int i = 0; i < Dim; ++i)
            if (std::abs(plane.normal[i]) == 1) axis = i;
        if (axis < 0)
            all = false;
        else if (plane.normal[axis] > 0)
            box.hi[axis] = std::min(box.hi[axis], plane.offset);
        else
            box.lo[axis] = std::max(box.lo[axis], -plane.offset);
    }
    return all;
}

}  // namespace

template <int Dim>
InputError nothingLeft(const Box<Dim>& whole) {
    return InputError(
        fmt::format("`clips`: nothing is left of the domain, which lies from ({:.6g}) to ({:.6g}) "
                    "mm; check where the clips lie, and the side that planes "
                    "keep (n.x <= d)",
                    fmt::join(whole.lo.c, ", "), fmt::join(whole.hi.c, ", ")));
}
template InputError nothingLeft<3>(const Box<3>&);

template <int Dim>
std::shared_ptr<const Domain<Dim>> clippedDomain(std::shared_ptr<const Domain<Dim>> domain,
                                                 const std::vector<HalfSpace<Dim>>& planes,
                                                 std::shared_ptr<const Domain<Dim>> envelope) {
    std::vector<HalfSpace<Dim>> unit = unitNormals(planes);
    if (unit.empty()) return domain;
    const Box<Dim> whole = domain->bounds();
    Box<Dim> box = whole;
    const bool axisAligned = cutAlongAxes(unit, box);
    if (box.empty() || !(box.volume() > 0)) throw nothingLeft(whole);
    const auto* clipped = dynamic_cast<const ClippedDomain<Dim>*>(domain.get());
    const std::string kind = domain->facts().kind;
    // A box cut along its axes is a box: every figure stays exact.
    if (axisAligned && clipped == nullptr && !envelope && (kind == "box" || kind == "rect"))
        return boxDomain<Dim>(box);
    if (clipped != nullptr) {
        unit.insert(unit.end(), clipped->planes().begin(), clipped->planes().end());
        const auto base = clipped->base();
        domain = base;
    }
    std::shared_ptr<const ClippedDomain<Dim>> result;
    if constexpr (Dim == 3)
        result = std::make_shared<SliceableClipped>(std::move(domain), std::move(unit),
                                                    std::move(envelope));
    else
        result = std::make_shared<ClippedDomain<Dim>>(std::move(domain), std::move(unit),
                                                      std::move(envelope));
    if (!(result->volume() > 0)) throw nothingLeft(whole);
    return result;
}

template std::shared_ptr<const Domain<2>> clippedDomain<2>(std::shared_ptr<const Domain<2>>,
                                                           const std::vector<HalfSpace<2>>&,
                                                           std::shared_ptr<const Domain<2>>);
template std::shared_ptr<const Domain<3>> clippedDomain<3>(std::shared_ptr<const Domain<3>>,
                                                           const std::vector<HalfSpace<3>>&,
                                                           std::shared_ptr<const Domain<3>>);

}  // namespace vdbpack
