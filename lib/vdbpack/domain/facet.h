// A facet of a wall: a triangle (2D: a segment).
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace vdbpack {

/// The corners of a triangle (2D: the ends of a segment), mm.
template <int Dim>
using Facet = std::array<Vec<Dim>, static_cast<std::size_t>(Dim)>;

template <std::size_t Dim>
Box<static_cast<int>(Dim)> facetBox(const std::array<Vec<static_cast<int>(Dim)>, Dim>& facet) {
    Box<static_cast<int>(Dim)> box;
    for (const auto& corner : facet) box.add(corner);
    return box;
}

/// Normal to the facet, of any length; zero where the facet has no area (2D: no length).
inline Vec<2> facetNormal(const Facet<2>& f) {
    const Vec<2> edge = f[1] - f[0];
    return {{-edge[1], edge[0]}};
}
inline Vec<3> facetNormal(const Facet<3>& f) {
    return cross(f[1] - f[0], f[2] - f[0]);
}

/// Squared distance of `x` to the segment from `a` to `a + edge`, and its nearest point.
template <int Dim>
double squaredDistanceToSegment(const Vec<Dim>& x, const Vec<Dim>& a, const Vec<Dim>& edge,
                                Vec<Dim>& point) {
    const Vec<Dim> to = x - a;
    const double square = squaredLength(edge);
    const double t = square > 0 ? std::clamp(dot(to, edge) / square, 0.0, 1.0) : 0.0;
    const Vec<Dim> offset = edge * t;
    point = a + offset;
    return squaredLength(to - offset);
}

/// Squared distance of `x` to a facet and its nearest point. Exact to rounding where the distance
/// is below `best` (squared too); else any value that is not below `best`.
inline double squaredDistanceToFacet(const Facet<2>& f, const Vec<2>& x, double, Vec<2>& point) {
    return squaredDistanceToSegment(x, f[0], f[1] - f[0], point);
}
inline double squaredDistanceToFacet(const Facet<3>& f, const Vec<3>& x, double best,
                                     Vec<3>& point) {
    const Vec<3> p = x - f[0];
    const Vec<3> ab = f[1] - f[0];
    const Vec<3> ac = f[2] - f[0];
    const Vec<3> n = cross(ab, ac);
    const double n2 = squaredLength(n);
    const double height = dot(n, p);
    // The plane is at most as far away as the triangle.
    if (height * height > best * n2) return std::numeric_limits<double>::infinity();
    // Barycentric coordinates times n2: `x` lies in the prism over the triangle where all three
    // are positive.
    const Vec<3> m = cross(p, n);
    const double sideAb = dot(ab, m);
    const double sideCa = -dot(ac, m);
    const double sideBc = n2 - sideAb - sideCa;
    if (n2 > 0 && sideAb >= 0 && sideCa >= 0 && sideBc >= 0) {
        point = x - n * (height / n2);
        return height * height / n2;
    }
    // The nearest point lies on one of the edges that `x` is beyond.
    double nearest = std::numeric_limits<double>::infinity();
    const auto tryEdge = [&](const Vec<3>& a, const Vec<3>& edge) {
        Vec<3> candidate;
        const double distance = squaredDistanceToSegment(x, a, edge, candidate);
        if (distance < nearest) {
            nearest = distance;
            point = candidate;
        }
    };
    if (sideAb < 0 || n2 == 0) tryEdge(f[0], ab);
    if (sideCa < 0 || n2 == 0) tryEdge(f[0], ac);
    if (sideBc < 0 || n2 == 0) tryEdge(f[1], f[2] - f[1]);
    return nearest;
}

}  // namespace vdbpack
