// Private to mesh and repair: lines along z through a mesh, by a rule that never counts an edge
// twice.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace vdbpack {

/// True if the half line from (x, y) towards +x crosses the edge a-b, seen along z.
///
/// Takes the vertices in the order of their indices, so that two triangles at an edge always get
/// the same answer, rounding included. Then the triangles of a closed piece that a vertical line
/// passes through are even in number, whatever the line hits.
inline bool crossesEdge(const TriangleMesh& mesh, std::uint32_t ia, std::uint32_t ib, double x,
                        double y) {
    if (ia > ib) std::swap(ia, ib);
    const Vec<3>& a = mesh.vertices[ia];
    const Vec<3>& b = mesh.vertices[ib];
    if ((a[1] > y) == (b[1] > y)) return false;
    const double side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    return b[1] > a[1] ? side > 0 : side < 0;
}

/// How often a triangle, seen along z, winds around `p`: 1 or -1 if the line along z through `p`
/// passes through it, by the sign of its normal's z; else 0.
inline int turnsAround(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t,
                       const Vec<3>& p) {
    int turns = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t[k], to = t[(k + 1) % 3];
        if (crossesEdge(mesh, from, to, p[0], p[1]))
            turns += mesh.vertices[to][1] > mesh.vertices[from][1] ? 1 : -1;
    }
    return turns;
}

/// True if the line along z through `p` passes through a triangle.
inline bool coversLine(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t,
                       const Vec<3>& p) {
    return turnsAround(mesh, t, p) != 0;
}

enum class Height { below, above, unclear };

/// Where the plane of a triangle passes `p`, seen along z.
inline Height heightOver(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t,
                         const Vec<3>& p) {
    const Vec<3> a = mesh.vertices[t[0]] - p;
    const Vec<3> b = mesh.vertices[t[1]] - p;
    const Vec<3> c = mesh.vertices[t[2]] - p;
    if (a[2] > 0 && b[2] > 0 && c[2] > 0) return Height::above;
    if (a[2] < 0 && b[2] < 0 && c[2] < 0) return Height::below;
    const Vec<3> n = cross(b - a, c - a);
    const double volume = dot(n, a);
    // Rounding of the products; a plane nearer than that to the point decides nothing.
    const double size = std::sqrt(std::max({squaredLength(a), squaredLength(b), squaredLength(c),
                                            std::numeric_limits<double>::min()}));
    const double noise = 1e-14 * size * size * size;
    if (!(std::fabs(volume) > noise) || n[2] == 0) return Height::unclear;
    return (volume > 0) == (n[2] > 0) ? Height::above : Height::below;
}

}  // namespace vdbpack
