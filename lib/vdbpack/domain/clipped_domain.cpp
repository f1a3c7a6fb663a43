#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/shape.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

// Lines and samples of the integrals below. A clipped ball comes out within 1e-5 of its volume.
constexpr int kChordsPerAxis3D = 1400;
constexpr int kChords2D = 200000;
constexpr double kMostSamples = 1.2e7;

/// Sums `rowSum(row)` over rows, in parallel and in an order that does not depend on threads.
template <class RowSum>
double sumOverRows(int rows, const RowSum& rowSum) {
    std::vector<double> sums(static_cast<std::size_t>(rows));
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, 8), [&](const tbb::blocked_range<int>& r) {
        for (int row = r.begin(); row != r.end(); ++row)
            sums[static_cast<std::size_t>(row)] = rowSum(row);
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// Solves the Dim x Dim system rows . x = rhs by Cramer's rule; false if nearly singular.
bool solve(const std::array<HalfSpace<2>, 2>& p, Vec<2>& x) {
    const double det = p[0].normal[0] * p[1].normal[1] - p[0].normal[1] * p[1].normal[0];
    if (std::abs(det) < 1e-9) return false;
    x[0] = (p[0].offset * p[1].normal[1] - p[0].normal[1] * p[1].offset) / det;
    x[1] = (p[0].normal[0] * p[1].offset - p[0].offset * p[1].normal[0]) / det;
    return true;
}

bool solve(const std::array<HalfSpace<3>, 3>& p, Vec<3>& x) {
    const Vec<3> c = cross(p[1].normal, p[2].normal);
    const double det = dot(p[0].normal, c);
    if (std::abs(det) < 1e-9) return false;
    x = (c * p[0].offset + cross(p[2].normal, p[0].normal) * p[1].offset +
         cross(p[0].normal, p[1].normal) * p[2].offset) *
        (1 / det);
    return true;
}

/// The bounds of a box cut by half-spaces (unit normals): of its corners, each the meeting point
/// of Dim of the planes that lies inside all others.
template <int Dim>
Box<Dim> cutBounds(const Box<Dim>& box, std::vector<HalfSpace<Dim>> planes) {
    Box<Dim> bounds;
    if (box.empty()) return bounds;
    for (int i = 0; i < Dim; ++i) {
        HalfSpace<Dim> low, high;
        low.normal[i] = -1;
        low.offset = -box.lo[i];
        high.normal[i] = 1;
        high.offset = box.hi[i];
        planes.push_back(low);
        planes.push_back(high);
    }
    double size = 0;
    for (int i = 0; i < Dim; ++i) size = std::max({size, std::abs(box.lo[i]), std::abs(box.hi[i])});
    const auto addCorner = [&](const std::array<HalfSpace<Dim>, Dim>& meeting) {
        Vec<Dim> x;
        if (!solve(meeting, x)) return;
        for (const auto& plane : planes)
            if (dot(plane.normal, x) > plane.offset + 1e-9 * size) return;
        bounds.add(x);
    };
    for (std::size_t i = 0; i < planes.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if constexpr (Dim == 2) {
                addCorner({planes[i], planes[j]});
            } else {
                for (std::size_t k = 0; k < j; ++k) addCorner({planes[i], planes[j], planes[k]});
            }
        }
    return bounds.empty() ? bounds : intersection(bounds, box);
}

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
    ClippedDomain(std::shared_ptr<const Domain<Dim>> base, std::vector<HalfSpace<Dim>> planes)
        : base_(std::move(base)),
          convex_(dynamic_cast<const ConvexShape<Dim>*>(base_.get())),
          planes_(std::move(planes)),
          bounds_(cutBounds(base_->bounds(), planes_)),
          volume_(volumeDeeperThan(0)) {}

    const std::shared_ptr<const Domain<Dim>>& base() const { return base_; }
    const std::vector<HalfSpace<Dim>>& planes() const { return planes_; }

    Box<Dim> bounds() const override { return bounds_; }
    double volume() const override { return volume_; }

    /// The rate at which the volume falls as the wall moves inward, by a one-sided difference
    /// of second order.
    double wallArea() const override {
        const Vec<Dim> size = bounds_.size();
        double step = size[0];
        for (int i = 1; i < Dim; ++i) step = std::min(step, size[i]);
        step *= 0.01;
        const double voxel = base_->facts().voxelSize;
        if (voxel > 0) step = std::clamp(step, 0.5 * voxel, 0.4 * base_->fieldDepth());
        return (3 * volume_ - 4 * volumeDeeperThan(step) + volumeDeeperThan(2 * step)) / (2 * step);
    }

    double volumeDeeperThan(double depth) const override {
        return convex_ ? measureByChords(depth) : measureBySamples(depth);
    }

    double fieldDepth() const override { return base_->fieldDepth(); }
    std::unique_ptr<DomainSampler<Dim>> sampler() const override {
        return std::make_unique<ClippedSampler<Dim>>(base_->sampler(), planes_);
    }
    DomainFacts facts() const override { return base_->facts(); }

private:
    /// Integral of exact chords along the last axis, midpoint rule across.
    double measureByChords(double depth) const {
        const auto planes = moved(planes_, depth);
        const Box<Dim> box = cutBounds(base_->bounds().grown(-depth), planes);
        if (box.empty() || !(box.measure() > 0)) return 0;
        const int n = Dim == 3 ? kChordsPerAxis3D : kChords2D;
        const Vec<Dim> step = box.size() * (1.0 / n);
        const auto chordLength = [&](const Vec<Dim>& x) {
            double lo = 0, hi = 0;
            if (!convex_->chord(x, depth, lo, hi)) return 0.0;
            for (const auto& plane : planes) {
                double rest = plane.offset;
                for (int i = 0; i + 1 < Dim; ++i) rest -= plane.normal[i] * x[i];
                const double slope = plane.normal[Dim - 1];
                if (slope > 0)
                    hi = std::min(hi, rest / slope);
                else if (slope < 0)
                    lo = std::max(lo, rest / slope);
                else if (rest < 0)
                    return 0.0;
            }
            return std::max(0.0, hi - lo);
        };
        if constexpr (Dim == 2) {
            return step[0] * sumOverRows(n, [&](int row) {
                       return chordLength({{box.lo[0] + (row + 0.5) * step[0], 0}});
                   });
        } else {
            return step[0] * step[1] * sumOverRows(n, [&](int row) {
                       double sum = 0;
                       for (int i = 0; i < n; ++i)
                           sum += chordLength({{box.lo[0] + (i + 0.5) * step[0],
                                                box.lo[1] + (row + 0.5) * step[1], 0}});
                       return sum;
                   });
        }
    }

    /// Sum over cells of the share that lies inside, from the distance at the cell's center: right
    /// for flat walls on average, and of second order in the cell for curved ones.
    double measureBySamples(double depth) const {
        const Box<Dim> box = bounds_;
        if (box.empty() || !(box.measure() > 0)) return 0;
        const Vec<Dim> size = box.size();
        const double finest = std::pow(box.measure() / kMostSamples, 1.0 / Dim);
        double cell = finest;
        // Below half a voxel there is nothing left to see in a field.
        if (Dim == 3) cell = std::max(finest, 0.5 * base_->facts().voxelSize);
        std::array<int, Dim> n{};
        Vec<Dim> step;
        double width = 0;
        for (int i = 0; i < Dim; ++i) {
            n[static_cast<std::size_t>(i)] =
                std::max(1, static_cast<int>(std::ceil(size[i] / cell)));
            step[i] = size[i] / n[static_cast<std::size_t>(i)];
            width = std::max(width, step[i]);
        }
        const std::size_t last = static_cast<std::size_t>(Dim - 1);
        const double cellMeasure =
            box.measure() / std::accumulate(n.begin(), n.end(), 1.0, std::multiplies<double>());
        return cellMeasure * sumOverRows(n[last], [&](int row) {
                   ClippedSampler<Dim> asker(base_->sampler(), planes_);
                   double sum = 0;
                   Vec<Dim> x;
                   x[Dim - 1] = box.lo[Dim - 1] + (row + 0.5) * step[Dim - 1];
                   const int middle = Dim == 3 ? n[1] : 1;
                   for (int j = 0; j < middle; ++j) {
                       if (Dim == 3) x[1] = box.lo[1] + (j + 0.5) * step[1];
                       for (int i = 0; i < n[0]; ++i) {
                           x[0] = box.lo[0] + (i + 0.5) * step[0];
                           const double outward = asker.signedDistance(x) + depth;
                           sum += std::clamp(0.5 - outward / width, 0.0, 1.0);
                       }
                   }
                   return sum;
               });
    }

    std::shared_ptr<const Domain<Dim>> base_;
    const ConvexShape<Dim>* convex_;
    std::vector<HalfSpace<Dim>> planes_;
    Box<Dim> bounds_;
    double volume_;
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
        return lines.empty() ? slice : clippedDomain<2>(slice, lines);
    }
};

}  // namespace

template <int Dim>
std::shared_ptr<const Domain<Dim>> clippedDomain(std::shared_ptr<const Domain<Dim>> domain,
                                                 const std::vector<HalfSpace<Dim>>& planes) {
    std::vector<HalfSpace<Dim>> unit;
    bool axisAligned = true;
    Box<Dim> box = domain->bounds();
    for (const auto& plane : planes) {
        const double scale = length(plane.normal);
        if (!(scale > 0) || !std::isfinite(scale) || !std::isfinite(plane.offset))
            throw ParameterError(
                "clip: a plane needs a finite normal other than zero and a finite offset; write "
                "it as plane:nx,ny,nz,d");
        unit.push_back({plane.normal * (1 / scale), plane.offset / scale});
        int axis = -1;
        for (int i = 0; i < Dim; ++i)
            if (std::abs(unit.back().normal[i]) == 1) axis = i;
        if (axis < 0)
            axisAligned = false;
        else if (unit.back().normal[axis] > 0)
            box.hi[axis] = std::min(box.hi[axis], unit.back().offset);
        else
            box.lo[axis] = std::max(box.lo[axis], -unit.back().offset);
    }
    if (unit.empty()) return domain;
    const auto nothingLeft = [&] {
        return InputError(
            "clip: nothing is left of the domain; check the side that the planes keep (n.x <= d)");
    };
    if (box.empty() || !(box.measure() > 0)) throw nothingLeft();
    const std::string kind = domain->facts().kind;
    if (axisAligned && (kind == "box" || kind == "rect")) {
        // A box cut along its axes is a box: keep every figure exact.
        if (dynamic_cast<const ClippedDomain<Dim>*>(domain.get()) == nullptr)
            return boxDomain<Dim>(box);
    }
    if (const auto* clipped = dynamic_cast<const ClippedDomain<Dim>*>(domain.get())) {
        unit.insert(unit.end(), clipped->planes().begin(), clipped->planes().end());
        const auto base = clipped->base();
        domain = base;
    }
    std::shared_ptr<const ClippedDomain<Dim>> result;
    if constexpr (Dim == 3)
        result = std::make_shared<SliceableClipped>(std::move(domain), std::move(unit));
    else
        result = std::make_shared<ClippedDomain<Dim>>(std::move(domain), std::move(unit));
    if (!(result->volume() > 0)) throw nothingLeft();
    return result;
}

template std::shared_ptr<const Domain<2>> clippedDomain<2>(std::shared_ptr<const Domain<2>>,
                                                           const std::vector<HalfSpace<2>>&);
template std::shared_ptr<const Domain<3>> clippedDomain<3>(std::shared_ptr<const Domain<3>>,
                                                           const std::vector<HalfSpace<3>>&);

}  // namespace vdbpack
