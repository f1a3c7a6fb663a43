// Private to mesh and repair: whether triangles of two solids pass through each other.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/mesh/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

/// Surfaces closer than this share of the smaller one's size touch: rounding to 32 bits.
inline constexpr double kTouching = 1e-6;

inline bool overlap(const Box<3>& a, const Box<3>& b) {
    return !intersection(a, b).empty();
}

inline TriangleTree::Corners cornersOf(const TriangleMesh& mesh,
                                       const std::array<std::uint32_t, 3>& t) {
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

/// Whether the segment passes through the triangle, with both ends off its plane; `at` is a point
/// on it just behind the triangle.
inline bool passes(const Vec<3>& p, const Vec<3>& q, const TriangleTree::Corners& t,
                   double tolerance, Vec<3>& at) {
    const Vec<3> normal = cross(t[1] - t[0], t[2] - t[0]);
    const double size = length(normal);
    if (!(size > 0)) return false;
    const double before = dot(normal, p - t[0]), after = dot(normal, q - t[0]);
    if ((before > 0) == (after > 0)) return false;
    if (std::min(std::fabs(before), std::fabs(after)) <= tolerance * size) return false;
    at = p + (q - p) * (before / (before - after));
    const auto isLeft = [&](const Vec<3>& from, const Vec<3>& to) {
        return dot(normal, cross(to - from, at - from)) >= 0;
    };
    if (!isLeft(t[0], t[1]) || !isLeft(t[1], t[2]) || !isLeft(t[2], t[0])) return false;
    const double depth = -std::min(before, after) / size;  // of the end behind the triangle
    at += ((before < 0 ? p : q) - at) * std::min(1.0, 4 * tolerance / depth);
    return true;
}

/// Whether an edge of a triangle passes through another one, with a part of the first solid behind
/// that. @param inOther  whether a point lies in the solid of the second triangle.
template <class Inside>
bool anyEdgePasses(const TriangleTree::Corners& own, const TriangleTree::Corners& other,
                   const Inside& inOther, double tolerance) {
    const Vec<3> ends[4] = {own[0], own[1], own[2], own[0]};
    for (int k = 0; k < 3; ++k) {
        Vec<3> x;
        if (!passes(ends[k], ends[k + 1], other, tolerance, x)) continue;
        // Into the solid of the edge: an edge that runs along the other's surface only touches it.
        const Vec<3> middle = (own[0] + own[1] + own[2]) * (1.0 / 3) - x;
        const Vec<3> back = cross(own[2] - own[0], own[1] - own[0]);
        if (!(squaredLength(back) > 0) || !(squaredLength(middle) > 0)) continue;
        if (inOther(x + (normalized(middle) + normalized(back)) * tolerance)) return true;
    }
    return false;
}

}  // namespace vdbpack
