#include "vdbpack/domain/analytic_domain.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/convex_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

void checkPositive(double value, const char* shape, const char* what) {
    if (!(value > 0) || !std::isfinite(value))
        throw ParameterError(
            fmt::format("{}: {} {} is invalid; give a positive length in mm", shape, what, value));
}

/// The shape itself. @throws ParameterError if its volume is no finite number above 0.
template <class Shape>
std::shared_ptr<Shape> withVolume(std::shared_ptr<Shape> shape, const char* name) {
    if (!(shape->volume() > 0) || !std::isfinite(shape->volume()))
        throw ParameterError(fmt::format(
            "{}: its volume or area comes to {}; give lengths that a bone could have, in mm", name,
            shape->volume()));
    return shape;
}

[[noreturn]] void planeMisses(double height, double lo, double hi) {
    throw InputError(
        fmt::format("slice z={}: the plane misses the domain, which spans z = {} to {} mm; choose "
                    "a height in between",
                    height, lo, hi));
}

template <int Dim>
class BoxDomain : public ConvexShape<Dim> {
public:
    /// @param wraps  axes along which it repeats: there are no walls along these.
    BoxDomain(const Box<Dim>& box, std::string kind, const std::array<bool, Dim>& wraps = {})
        : ConvexShape<Dim>(std::move(kind)),
          box_(box),
          wraps_(wraps),
          center_(box.center()),
          half_(box.size() * 0.5) {}

    Box<Dim> bounds() const override { return box_; }
    double volume() const override { return box_.volume(); }
    double wallArea() const override {
        double sum = 0;
        for (int i = 0; i < Dim; ++i) {
            double face = hasWalls(i) ? 2 : 0;
            for (int j = 0; j < Dim; ++j)
                if (j != i) face *= 2 * half_[j];
            sum += face;
        }
        return sum;
    }
    double volumeDeeperThan(double depth) const override {
        Box<Dim> deep = box_.grown(-depth);
        for (int i = 0; i < Dim; ++i)
            if (!hasWalls(i)) deep.lo[i] = box_.lo[i], deep.hi[i] = box_.hi[i];
        return deep.volume();
    }
    PeriodicCell<Dim> cell() const override { return {box_, wraps_}; }

    bool chord(const Vec<Dim>& x, double depth, double& lo, double& hi) const override {
        for (int i = 0; i + 1 < Dim; ++i)
            if (!(std::abs(x[i] - center_[i]) < half_[i] - (hasWalls(i) ? depth : 0))) return false;
        const double from = hasWalls(Dim - 1) ? depth : 0;
        lo = box_.lo[Dim - 1] + from;
        hi = box_.hi[Dim - 1] - from;
        return lo < hi;
    }

    double signedDistance(const Vec<Dim>& x) const override {
        double inside = -std::numeric_limits<double>::infinity();
        double outside = 0;
        for (int i = 0; i < Dim; ++i) {
            if (!hasWalls(i)) continue;
            const double q = std::abs(x[i] - center_[i]) - half_[i];
            inside = std::max(inside, q);
            if (q > 0) outside += q * q;
        }
        return outside > 0 ? std::sqrt(outside) : inside;
    }

    Vec<Dim> nearestOnWall(const Vec<Dim>& x) const override {
        Vec<Dim> p = x;
        bool outside = false;
        int nearestAxis = 0;
        double nearest = std::numeric_limits<double>::infinity();
        for (int i = 0; i < Dim; ++i) {
            if (!hasWalls(i)) continue;
            p[i] = std::clamp(x[i], box_.lo[i], box_.hi[i]);
            outside = outside || p[i] != x[i];
            const double q = half_[i] - std::abs(x[i] - center_[i]);
            if (q < nearest) {
                nearest = q;
                nearestAxis = i;
            }
        }
        if (!outside)
            p[nearestAxis] =
                x[nearestAxis] < center_[nearestAxis] ? box_.lo[nearestAxis] : box_.hi[nearestAxis];
        return p;
    }

    void wallsWithin(const Vec<Dim>& x, double reach,
                     std::vector<WallPoint<Dim>>& points) const override {
        if (signedDistance(x) > 0) {
            ConvexShape<Dim>::wallsWithin(x, reach, points);
            return;
        }
        for (int i = 0; i < Dim; ++i)
            for (const double face : {box_.lo[i], box_.hi[i]}) {
                if (!hasWalls(i) || !(std::abs(x[i] - face) < reach)) continue;
                points.push_back({x, std::abs(x[i] - face)});
                points.back().point[i] = face;
            }
    }

private:
    bool hasWalls(int axis) const { return !wraps_[static_cast<std::size_t>(axis)]; }

    Box<Dim> box_;
    std::array<bool, Dim> wraps_;
    Vec<Dim> center_;
    Vec<Dim> half_;
};

template <int Dim>
class BallDomain : public ConvexShape<Dim> {
public:
    BallDomain(double radius, const Vec<Dim>& center, std::string kind)
        : ConvexShape<Dim>(std::move(kind)), radius_(radius), center_(center) {}

    Box<Dim> bounds() const override { return Box<Dim>{center_, center_}.grown(radius_); }
    double volume() const override { return Measure<Dim>::ball(radius_); }
    double wallArea() const override {
        return Dim == 3 ? 4 * kPi * radius_ * radius_ : 2 * kPi * radius_;
    }
    double volumeDeeperThan(double depth) const override {
        return Measure<Dim>::ball(std::max(0.0, radius_ - depth));
    }

    bool chord(const Vec<Dim>& x, double depth, double& lo, double& hi) const override {
        const double r = radius_ - depth;
        double square = r > 0 ? r * r : 0;
        for (int i = 0; i + 1 < Dim; ++i) square -= (x[i] - center_[i]) * (x[i] - center_[i]);
        if (!(square > 0)) return false;
        lo = center_[Dim - 1] - std::sqrt(square);
        hi = center_[Dim - 1] + std::sqrt(square);
        return true;
    }

    double signedDistance(const Vec<Dim>& x) const override {
        return length(x - center_) - radius_;
    }

    Vec<Dim> nearestOnWall(const Vec<Dim>& x) const override {
        Vec<Dim> direction = normalized(x - center_);
        if (squaredLength(direction) == 0) direction[0] = 1;  // all are equally near the center
        return center_ + direction * radius_;
    }

    double radius() const { return radius_; }
    const Vec<Dim>& center() const { return center_; }

private:
    double radius_;
    Vec<Dim> center_;
};

class SliceableBox : public BoxDomain<3>, public Sliceable {
public:
    using BoxDomain<3>::BoxDomain;
    std::shared_ptr<const Domain<2>> slice(double height) const override {
        const Box<3> b = bounds();
        if (!(b.lo[2] < height && height < b.hi[2])) planeMisses(height, b.lo[2], b.hi[2]);
        return std::make_shared<BoxDomain<2>>(Box<2>{{{b.lo[0], b.lo[1]}}, {{b.hi[0], b.hi[1]}}},
                                              "slice");
    }
};

class SliceableBall : public BallDomain<3>, public Sliceable {
public:
    using BallDomain<3>::BallDomain;
    std::shared_ptr<const Domain<2>> slice(double height) const override {
        const double z = height - center()[2];
        const double square = (radius() - z) * (radius() + z);
        if (!(square > 0)) planeMisses(height, center()[2] - radius(), center()[2] + radius());
        return std::make_shared<BallDomain<2>>(std::sqrt(square),
                                               Vec<2>{{center()[0], center()[1]}}, "slice");
    }
};

/// Around the z axis, centered at the origin: a rectangle in (distance from the axis, z).
class CylinderDomain : public ConvexShape<3>, public Sliceable {
public:
    CylinderDomain(double radius, double height)
        : ConvexShape<3>("cylinder"), radius_(radius), half_(height / 2) {}

    Box<3> bounds() const override {
        return {{{-radius_, -radius_, -half_}}, {{radius_, radius_, half_}}};
    }
    double volume() const override { return kPi * radius_ * radius_ * 2 * half_; }
    double wallArea() const override { return 2 * kPi * radius_ * (radius_ + 2 * half_); }
    double volumeDeeperThan(double depth) const override {
        const double r = std::max(0.0, radius_ - depth);
        return kPi * r * r * 2 * std::max(0.0, half_ - depth);
    }

    bool chord(const Vec<3>& x, double depth, double& lo, double& hi) const override {
        if (!(std::hypot(x[0], x[1]) < radius_ - depth)) return false;
        lo = -half_ + depth;
        hi = half_ - depth;
        return lo < hi;
    }

    double signedDistance(const Vec<3>& x) const override {
        const double side = std::hypot(x[0], x[1]) - radius_;
        const double end = std::abs(x[2]) - half_;
        if (side > 0 && end > 0) return std::hypot(side, end);
        return std::max(side, end);
    }

    Vec<3> nearestOnWall(const Vec<3>& x) const override {
        const double rho = std::hypot(x[0], x[1]);
        const double side = rho - radius_;
        const double end = std::abs(x[2]) - half_;
        const bool toSide = side > 0 || (end <= 0 && side >= end);
        const bool toEnd = end > 0 || (side <= 0 && end > side);
        Vec<3> p = x;
        if (toSide) {
            p[0] = rho > 0 ? x[0] * (radius_ / rho) : radius_;
            p[1] = rho > 0 ? x[1] * (radius_ / rho) : 0;
        }
        if (toEnd) p[2] = x[2] < 0 ? -half_ : half_;
        return p;
    }

    void wallsWithin(const Vec<3>& x, double reach,
                     std::vector<WallPoint<3>>& points) const override {
        if (signedDistance(x) > 0) {
            ConvexShape<3>::wallsWithin(x, reach, points);
            return;
        }
        const double rho = std::hypot(x[0], x[1]);
        if (radius_ - rho < reach) {
            const double out = rho > 0 ? radius_ / rho : 0;
            points.push_back({{{rho > 0 ? x[0] * out : radius_, x[1] * out, x[2]}}, radius_ - rho});
        }
        for (const double end : {-half_, half_})
            if (std::abs(x[2] - end) < reach)
                points.push_back({{{x[0], x[1], end}}, std::abs(x[2] - end)});
    }

    std::shared_ptr<const Domain<2>> slice(double height) const override {
        if (!(std::abs(height) < half_)) planeMisses(height, -half_, half_);
        return std::make_shared<BallDomain<2>>(radius_, Vec<2>{}, "slice");
    }

private:
    double radius_;
    double half_;
};

template <int Dim>
void checkBox(const Box<Dim>& box, const char* name) {
    for (int i = 0; i < Dim; ++i)
        if (!std::isfinite(box.lo[i]) || !std::isfinite(box.hi[i]) || !(box.lo[i] < box.hi[i]))
            throw ParameterError(fmt::format(
                "{}: axis {} runs from {} to {}; give finite bounds in mm, the lower one first",
                name, "xyz"[i], box.lo[i], box.hi[i]));
}

}  // namespace

template <int Dim>
std::shared_ptr<const Domain<Dim>> boxDomain(const Box<Dim>& box) {
    const char* name = Dim == 3 ? "box" : "rect";
    checkBox(box, name);
    if constexpr (Dim == 3)
        return withVolume(std::make_shared<SliceableBox>(box, name), name);
    else
        return withVolume(std::make_shared<BoxDomain<Dim>>(box, name), name);
}

template <int Dim>
std::shared_ptr<const Domain<Dim>> periodicDomain(const PeriodicCell<Dim>& cell) {
    checkBox(cell.box, "periodic");
    return withVolume(std::make_shared<BoxDomain<Dim>>(cell.box, "periodic", cell.wraps),
                      "periodic");
}

template <int Dim>
std::shared_ptr<const Domain<Dim>> ballDomain(double radius, const Vec<Dim>& center) {
    const char* name = Dim == 3 ? "ball" : "disc";
    checkPositive(radius, name, "radius");
    if (!isFinite(center))
        throw ParameterError(fmt::format("{}: the center is not finite; give it in mm", name));
    if constexpr (Dim == 3)
        return withVolume(std::make_shared<SliceableBall>(radius, center, name), name);
    else
        return withVolume(std::make_shared<BallDomain<Dim>>(radius, center, name), name);
}

std::shared_ptr<const Domain<3>> cylinderDomain(double radius, double height) {
    checkPositive(radius, "cylinder", "radius");
    checkPositive(height, "cylinder", "height");
    return withVolume(std::make_shared<CylinderDomain>(radius, height), "cylinder");
}

template std::shared_ptr<const Domain<2>> boxDomain<2>(const Box<2>&);
template std::shared_ptr<const Domain<3>> boxDomain<3>(const Box<3>&);
template std::shared_ptr<const Domain<2>> periodicDomain<2>(const PeriodicCell<2>&);
template std::shared_ptr<const Domain<3>> periodicDomain<3>(const PeriodicCell<3>&);
template std::shared_ptr<const Domain<2>> ballDomain<2>(double, const Vec<2>&);
template std::shared_ptr<const Domain<3>> ballDomain<3>(double, const Vec<3>&);

}  // namespace vdbpack
