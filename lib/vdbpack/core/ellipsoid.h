// Ellipsoids of revolution (2D: ellipses), the shape of voids.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// An ellipse, or an ellipsoid of revolution about its half-axis `a`.
template <int Dim>
struct Ellipsoid {
    Vec<Dim> center;       ///< mm
    double a = 0;          ///< half-axis along `axis`, mm
    double b = 0;          ///< half-axes across it, mm; may be larger than `a`
    Vec<Dim> axis;         ///< of length one; its sign means nothing
    std::uint32_t id = 0;  ///< a number of its own; with those of others it decides on their struts

    /// Volume (2D: area), mm^Dim.
    double volume() const { return a * std::pow(b, Dim - 1) * Measure<Dim>::ball(1); }

    bool contains(const Vec<Dim>& x) const {
        const Vec<Dim> to = x - center;
        const double along = dot(to, axis);
        const double across = std::max(0.0, squaredLength(to) - along * along);
        return along * along / (a * a) + across / (b * b) < 1;
    }

    /// Distance to the surface, mm, negative inside. Exact to about 1e-7 of the larger half-axis.
    double signedDistance(const Vec<Dim>& x) const {
        const Vec<Dim> to = x - center;
        const double along = dot(to, axis);
        const double across = std::sqrt(std::max(0.0, squaredLength(to) - along * along));
        const double d = ellipseDistance(a, b, std::fabs(along), across);
        return contains(x) ? -d : d;
    }

    /// The box around it.
    Box<Dim> bounds() const {
        Box<Dim> box;
        for (int i = 0; i < Dim; ++i) {
            const double n = axis[i] * axis[i];
            const double half = std::sqrt(a * a * n + b * b * std::max(0.0, 1 - n));
            box.lo[i] = center[i] - half;
            box.hi[i] = center[i] + half;
        }
        return box;
    }

private:
    /// Distance of (x, y) in the first quadrant to the ellipse with half-axes a, b along them: the
    /// ellipse's circle of curvature at the last foot gives the next.
    static double ellipseDistance(double a, double b, double x, double y) {
        double tx = std::sqrt(0.5), ty = tx;
        const double focus = a * a - b * b;
        double distance = 0;
        for (int step = 0; step < 24; ++step) {
            const double ex = focus * tx * tx * tx / a, ey = -focus * ty * ty * ty / b;
            const double r = std::hypot(a * tx - ex, b * ty - ey);
            const double q = std::hypot(x - ex, y - ey);
            if (!(q > 0)) break;  // the center of curvature: every foot nearby is as near
            tx = std::clamp(((x - ex) * r / q + ex) / a, 0.0, 1.0);
            ty = std::clamp(((y - ey) * r / q + ey) / b, 0.0, 1.0);
            const double l = std::hypot(tx, ty);
            if (!(l > 0)) return std::min(std::fabs(a - x), std::fabs(b - y));
            tx /= l;
            ty /= l;
            const double before = distance;
            distance = std::hypot(a * tx - x, b * ty - y);
            if (std::fabs(distance - before) < 1e-9 * std::max(a, b)) break;
        }
        return std::hypot(a * tx - x, b * ty - y);
    }
};

/// The shortest half-axis of all, mm; infinity if there are none.
template <int Dim>
double leastHalfAxis(const std::vector<Ellipsoid<Dim>>& ellipsoids) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& e : ellipsoids) least = std::min({least, e.a, e.b});
    return least;
}

/// The long axis of a void as its angles say, rad: along z, turned by `thetaX` about x, then by
/// `thetaZ` about z.
inline Vec<3> axisOf(double thetaZ, double thetaX) {
    return {{std::sin(thetaX) * std::sin(thetaZ), -std::sin(thetaX) * std::cos(thetaZ),
             std::cos(thetaX)}};
}
/// The same in the plane: along x, turned by `phi`, rad.
inline Vec<2> axisOf(double phi) {
    return {{std::cos(phi), std::sin(phi)}};
}

}  // namespace vdbpack
