#include "vdbpack/domain/function_domain.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/box_planes.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/volume_integrals.h"
#include "vdbpack/field/level_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

// Points along each axis where a function is checked.
constexpr int kCheckedPoints = 33;
// Step of the differences that approximate the gradient, in longest sides of the bounds: rounding
// and curvature then turn it by less than 1e-7.
constexpr double kStep = 1e-5;
// The projection of a point must reduce its distance by this factor. It does not where the gradient
// is undefined, at equal distances to two walls: it is then taken at a point close by.
constexpr double kProjected = 1e-3;
constexpr double kCloseBy = 1e-3;

template <int Dim>
using Function = std::function<double(const Vec<Dim>&)>;

template <int Dim>
double longestSide(const Box<Dim>& box) {
    const Vec<Dim> size = box.size();
    return *std::max_element(size.c.begin(), size.c.end());
}

template <int Dim>
class FunctionSampler : public DomainSampler<Dim> {
public:
    FunctionSampler(const Function<Dim>& f, double scale, double step,
                    std::unique_ptr<DomainSampler<Dim>> box)
        : f_(f), scale_(scale), step_(step), box_(std::move(box)) {}

    double signedDistance(const Vec<Dim>& x) override {
        return std::max(f_(x) * scale_, box_->signedDistance(x));
    }

    // The complement of an intersection is the union of complements, so from inside the nearer of
    // the two walls is the nearest wall.
    bool nearestWall(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) override {
        const bool found = nearestOfFunction(x, reach, wall);
        return box_->nearestWall(x, found ? wall.distance : reach, wall) || found;
    }

    void wallsWithin(const Vec<Dim>& x, double reach,
                     std::vector<WallPoint<Dim>>& points) override {
        WallPoint<Dim> wall;
        if (nearestOfFunction(x, reach, wall)) points.push_back(wall);
        box_->wallsWithin(x, reach, points);
    }

    bool isWallCloser(const Vec<Dim>& x, double reach) override {
        return std::abs(f_(x) * scale_) < reach || box_->isWallCloser(x, reach);
    }

private:
    bool nearestOfFunction(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) const {
        const double distance = f_(x) * scale_;
        if (!(std::abs(distance) < reach)) return false;
        wall.distance = std::abs(distance);
        for (int attempt = 0; attempt <= Dim; ++attempt) {
            Vec<Dim> at = x;
            if (attempt > 0) at[attempt - 1] += std::max(kCloseBy * wall.distance, 2 * step_);
            wall.point = x - direction(at) * distance;
            if (std::abs(f_(wall.point) * scale_) <= kProjected * wall.distance) break;
        }
        return true;
    }

    /// The direction in which the function grows most, by central differences.
    Vec<Dim> direction(const Vec<Dim>& x) const {
        Vec<Dim> gradient;
        for (int i = 0; i < Dim; ++i) {
            Vec<Dim> low = x, high = x;
            low[i] -= step_;
            high[i] += step_;
            gradient[i] = f_(high) - f_(low);
        }
        return normalized(gradient);
    }

    const Function<Dim>& f_;
    double scale_;  // 1 / the largest gradient
    double step_;   // mm
    std::unique_ptr<DomainSampler<Dim>> box_;
};

template <int Dim>
class FunctionDomain : public Domain<Dim> {
public:
    FunctionDomain(Function<Dim> f, const Box<Dim>& bounds, double steepest)
        : f_(std::move(f)),
          scale_(1 / steepest),
          bounds_(bounds),
          box_(boxDomain<Dim>(bounds)),
          longest_(longestSide(bounds)) {}

    /// Integrates the volume, which a domain that is only sampled does not need.
    void integrate() { whole_ = partDeeperThan(0); }

    Box<Dim> bounds() const override { return bounds_; }
    double volume() const override { return whole_.volume; }
    std::optional<Vec<Dim>> centroid() const override { return whole_.centroid(); }
    double wallArea() const override { return wallAreaByVolumes(*this, 0.005 * longest_); }
    double volumeDeeperThan(double depth) const override { return partDeeperThan(depth).volume; }
    double fieldDepth() const override { return std::numeric_limits<double>::infinity(); }
    std::unique_ptr<DomainSampler<Dim>> sampler() const override {
        return std::make_unique<FunctionSampler<Dim>>(f_, scale_, kStep * longest_,
                                                      box_->sampler());
    }
    DomainFacts facts() const override {
        DomainFacts facts;
        facts.kind = "function";
        return facts;
    }

private:
    VolumeIntegrals<Dim> partDeeperThan(double depth) const {
        return integralsBySamples<Dim>(bounds_, 0, depth, [this] { return sampler(); });
    }

    Function<Dim> f_;
    double scale_;
    Box<Dim> bounds_;
    std::shared_ptr<const Domain<Dim>> box_;
    double longest_;
    VolumeIntegrals<Dim> whole_;
};

template <int Dim>
std::string textOf(const Vec<Dim>& x) {
    std::string text;
    for (int i = 0; i < Dim; ++i) text += fmt::format("{}{:.6g}", i > 0 ? ", " : "", x[i]);
    return "(" + text + ")";
}

/// Evaluates the function on a coarse lattice and compares neighbors.
/// @throws InputError for what `functionDomain` refuses.
template <int Dim>
void checkValues(const Function<Dim>& f, const Box<Dim>& bounds, const FunctionOptions& options) {
    const Vec<Dim> step = bounds.size() * (1.0 / (kCheckedPoints - 1));
    std::size_t points = 1;
    for (int i = 0; i < Dim; ++i) points *= kCheckedPoints;
    std::vector<double> values(points);
    for (std::size_t p = 0; p < points; ++p) {
        Vec<Dim> x;
        std::size_t stride = 1;
        for (int i = 0; i < Dim; ++i) {
            const std::size_t at = p / stride % kCheckedPoints;
            x[i] = bounds.lo[i] + static_cast<double>(at) * step[i];
            stride *= kCheckedPoints;
        }
        values[p] = f(x);
        if (!std::isfinite(values[p]))
            throw InputError(fmt::format("{}: the value at {} mm is {}; return a finite number",
                                         options.name, textOf(x), values[p]));
        stride = 1;
        for (int i = 0; i < Dim; ++i) {
            if (p / stride % kCheckedPoints > 0) {
                const double slope = std::abs(values[p] - values[p - stride]) / step[i];
                if (slope > options.steepest * (1 + 1e-6))
                    throw InputError(
                        fmt::format("{}: the gradient near {} mm is {:.4g} or more, larger than "
                                    "`steepest` {:.4g}; pass the largest gradient",
                                    options.name, textOf(x), slope, options.steepest));
            }
            stride *= kCheckedPoints;
        }
    }
}

template <int Dim>
std::shared_ptr<FunctionDomain<Dim>> checkedDomain(Function<Dim> f, const Box<Dim>& bounds,
                                                   const Box<Dim>& checked,
                                                   const FunctionOptions& options) {
    if (!f) throw ParameterError(fmt::format("{}: the function is empty", options.name));
    if (!(options.steepest > 0) || !std::isfinite(options.steepest))
        throw ParameterError(fmt::format("{}: `steepest` {} must be positive and finite",
                                         options.name, options.steepest));
    auto domain = std::make_shared<FunctionDomain<Dim>>(f, bounds, options.steepest);
    checkValues(f, checked, options);
    return domain;
}

}  // namespace

template <int Dim>
std::shared_ptr<const Domain<Dim>> functionDomain(std::function<double(const Vec<Dim>&)> f,
                                                  const Box<Dim>& bounds,
                                                  const FunctionOptions& options) {
    const auto domain = checkedDomain<Dim>(std::move(f), bounds, bounds, options);
    domain->integrate();
    if (!(domain->volume() > 0))
        throw InputError(fmt::format(
            "{}: it is negative nowhere within the bounds; distances are negative inside",
            options.name));
    return domain;
}

std::shared_ptr<const Domain<3>> implicitDomain(std::function<double(const Vec<3>&)> f,
                                                const Box<3>& bounds,
                                                const FunctionOptions& options,
                                                const FieldOptions& field,
                                                const Callbacks& callbacks) {
    boxDomain<3>(bounds);  // refuses unusable bounds
    double voxelSize = field.voxelSize > 0 ? field.voxelSize : 0.5 * field.detail;
    if (!(voxelSize > 0)) voxelSize = longestSide(bounds) / 128;
    // The contour rounds the edges of a box that is sampled: those of a larger one are cut off.
    const auto domain =
        checkedDomain<3>(std::move(f), bounds.grown(2 * voxelSize), bounds, options);
    const TriangleMesh mesh = levelSetMesh(*surfaceLevelSet(*domain, voxelSize), options.name);
    FieldOptions named = field;
    named.name = options.name;
    const auto inside = meshDomain(mesh, named, callbacks);
    const Box<3> extent = inside->bounds();
    const bool isWithin = bounds.contains(extent.lo) && bounds.contains(extent.hi);
    if (isWithin) return inside;
    return clippedDomain<3>(inside, halfSpacesOf(bounds));
}

template std::shared_ptr<const Domain<2>> functionDomain(std::function<double(const Vec<2>&)>,
                                                         const Box<2>&, const FunctionOptions&);
template std::shared_ptr<const Domain<3>> functionDomain(std::function<double(const Vec<3>&)>,
                                                         const Box<3>&, const FunctionOptions&);

}  // namespace vdbpack
