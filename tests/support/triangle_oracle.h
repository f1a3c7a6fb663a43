// Distances and solid angles of single triangles.
#pragma once

#include "vdbpack/core/vec.h"

#include <algorithm>
#include <cmath>

namespace vdbpack::test {

/// Distance to a triangle by the region of its plane (Ericson 2005, Real-Time Collision Detection,
/// 5.1.5); of a triangle without area to its sides.
inline double distanceTo(const Vec<3>& p, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
    const auto toSide = [&](const Vec<3>& from, const Vec<3>& to) {
        const Vec<3> along = to - from;
        const double square = squaredLength(along);
        const double t = square > 0 ? std::clamp(dot(p - from, along) / square, 0.0, 1.0) : 0.0;
        return length(p - from - along * t);
    };
    double least = std::min({toSide(a, b), toSide(b, c), toSide(c, a)});
    const Vec<3> n = cross(b - a, c - a);
    const double square = squaredLength(n);
    if (square > 1e-16 * squaredLength(b - a) * squaredLength(c - a) &&
        dot(cross(n, b - a), p - a) >= 0 && dot(cross(n, c - b), p - b) >= 0 &&
        dot(cross(n, a - c), p - c) >= 0)
        least = std::min(least, std::abs(dot(n, p - a)) / std::sqrt(square));
    return least;
}

/// Solid angle of a triangle (Van Oosterom, Strackee 1983, doi:10.1109/TBME.1983.325207).
inline double solidAngle(const Vec<3>& p, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
    const Vec<3> x = a - p, y = b - p, z = c - p;
    const double lx = length(x), ly = length(y), lz = length(z);
    return 2 * std::atan2(dot(x, cross(y, z)),
                          lx * ly * lz + dot(x, y) * lz + dot(y, z) * lx + dot(z, x) * ly);
}

}  // namespace vdbpack::test
