// Private: the faces, edges and vertices of a mesh, each with the part of a narrow band whose
// nearest point it may hold.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/field/band/block_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdbpack {

/// Normals that differ by no more than this count as one: coordinates in single precision tilt
/// small triangles of a flat face by about as much. Edges and vertices between such triangles are
/// left out. Points in the gaps over them count as over the triangles beside: their distances are
/// too small by at most 1.5 kFlat^2 of themselves.
constexpr double kFlat = 1e-4;

/// Widths of a band on the side that the normal of a triangle points to and on the other, voxels.
struct BandWidths {
    float above = 0, below = 0;
    float larger() const { return above > below ? above : below; }
};

/// Unit normal of a triangle; zero if it is degenerate: its edges hold all of its points to 1e-7
/// of a voxel.
inline Vec<3> bandNormal(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
    // The height over the longest side is what the normal depends on.
    const Vec<3> ab = b - a, ac = c - a, bc = c - b;
    const Vec<3> n = cross(ab, ac);
    const double longest = std::max({squaredLength(ab), squaredLength(ac), squaredLength(bc)});
    const double square = squaredLength(n);
    if (!(square > 1e-14 * longest)) return {};
    return n * (1 / std::sqrt(square));
}

/// A mesh on a lattice.
struct BandMesh {
    std::vector<Vec<3>> vertices;  ///< in voxels
    const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr;
    const std::int8_t* facing = nullptr;  ///< as `Facing`; null: unknown
    float inside = 0, outside = 0;        ///< widths of the band, voxels
    Box<3> bounds;                        ///< of the triangles, voxels

    const Vec<3>& corner(std::size_t triangle, std::size_t k) const {
        return vertices[(*triangles)[triangle][k]];
    }
    Vec<3> normal(std::size_t triangle) const {
        return bandNormal(corner(triangle, 0), corner(triangle, 1), corner(triangle, 2));
    }
    BandWidths widths(std::size_t triangle) const {
        const int side = facing ? facing[triangle] : 0;
        if (side == 0) return {std::max(inside, outside), std::max(inside, outside)};
        return side > 0 ? BandWidths{outside, inside} : BandWidths{inside, outside};
    }
};

/// An edge that is nearest to points of the band: of the wedge between its two triangles on the
/// side where they bend away.
struct BandEdge {
    std::uint32_t a, b;  ///< vertices, a < b
    float reach;         ///< distance to the farthest point, voxels
    /// The wedge spans from the edge to these unit vectors across it, and to all that a
    /// right-handed turn about the edge takes from n0 to n1. Zero: all around the edge.
    Vec<3> n0, n1;

    bool hasWedge() const { return squaredLength(n0) > 0; }
    // The wedge is where products with these are not negative. @param along  from a to b.
    Vec<3> inward0(const Vec<3>& along) const { return cross(along, n0); }
    Vec<3> inward1(const Vec<3>& along) const { return cross(n1, along); }
};

/// A vertex that is nearest to points of the band: in a cone.
struct BandVertex {
    std::uint32_t vertex;
    float reach;
    std::array<float, 3> axis;  ///< of the cone, unit length
    float cosine;               ///< of half the angle of the cone; -1: all directions
};

struct BandFeatures {
    BlockList<BandEdge> edges;
    BlockList<BandVertex> vertices;
};

/// Takes an edge or a vertex; true if it is dealt with, so that it need not be kept. Called from
/// several threads.
struct FeatureVisits {
    std::function<bool(const BandEdge&)> edge;
    std::function<bool(const BandVertex&)> vertex;
};

/// The edges and vertices that matter and that no visit deals with. A point of the band is nearest
/// to one of them, or to the inside of a triangle; flat edges and vertices are left out.
///
/// The region of an edge is the set of points whose projection onto none of its triangles comes
/// nearer (the product of the point with the direction into each triangle is not positive), that
/// of a vertex the polar cone of its edges.
BandFeatures bandFeatures(const BandMesh& mesh, const FeatureVisits& visits,
                          const Callbacks& callbacks);

}  // namespace vdbpack
