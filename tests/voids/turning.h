// A direction field by formula.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/core/vec.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

/// Turns by 90 degrees from x = 0 to x = `length` (mm), in a plane askew to all axes.
inline Vec<3> turning(const Vec<3>& x, double length) {
    const Vec<3> p = normalized(Vec<3>{{1, 2, -1}}), q = normalized(cross(p, {{0.3, 1, 1}}));
    const double angle = 0.5 * kPi * x[0] / length;
    return p * std::cos(angle) + q * std::sin(angle);
}

/// Angle between two directions of length one, whatever their signs, degrees.
inline double degreesBetween(const Vec<3>& a, const Vec<3>& b) {
    return std::atan2(length(cross(a, b)), std::fabs(dot(a, b))) * 180 / kPi;
}

}  // namespace vdbpack
