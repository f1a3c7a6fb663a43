// The health of a triangle mesh: what a packer must know before it trusts the inside.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The largest hole: connected boundary edges, by total length.
struct BoundaryLoop {
    std::size_t edges = 0;
    double length = 0;  ///< mm
    Vec<3> center;      ///< of the edges, weighted by length, mm
};

/// Where a mesh is open.
struct MeshLeak {
    std::uint32_t vertex = 0;  ///< the lowest vertex on a boundary edge, counted from 0
    Vec<3> position;           ///< of that vertex, mm
    std::size_t loops = 0;     ///< groups of connected boundary edges
    BoundaryLoop largest;
};

/// Counts and measures of a mesh. Triangles that use a vertex twice count as degenerate; `edges`
/// and `eulerNumber` leave them out.
struct MeshHealth {
    std::size_t triangles = 0;
    std::size_t vertices = 0;             ///< used by a triangle
    std::size_t edges = 0;                ///< distinct
    std::size_t pieces = 0;               ///< components connected by shared vertices
    std::size_t shells = 0;               ///< components connected by shared edges (mesh_shells.h)
    std::size_t boundaryEdges = 0;        ///< with one triangle
    std::size_t nonManifoldEdges = 0;     ///< with three triangles or more
    std::size_t unbalancedEdges = 0;      ///< of these, with more triangles one way than the other
    std::size_t inconsistentEdges = 0;    ///< with two triangles of opposite orientation
    std::size_t duplicateTriangles = 0;   ///< with the same three vertices as an earlier one
    std::size_t degenerateTriangles = 0;  ///< without area: height below 1e-9 of the longest side
    std::int64_t eulerNumber = 0;         ///< vertices - edges + triangles
    Box<3> bounds;                        ///< mm
    double area = 0;                      ///< mm²
    double signedVolume = 0;    ///< divergence theorem over all shells, mm³; < 0: facing inward
    double enclosedVolume = 0;  ///< without cavities, for any orientation, mm³ (mesh_shells.h)
    std::vector<std::size_t> shellsAtDepth;  ///< [d]: shells inside d closed ones
    /// Closed shells of wrong orientation: outer ones that face inward, cavities that face outward.
    std::size_t invertedShells = 0;
    std::size_t intersections = 0;  ///< pairs of closed shells that intersect (mesh_shells.h)
    double intersectionVolume = 0;  ///< inside both of a pair, mm³, to some 2 %
    Vec<3> intersectionAt;          ///< middle of the largest such volume, mm
    std::optional<MeshLeak> leak;   ///< none if there is no boundary edge

    /// No boundary edges: every shell has an inside.
    bool isClosed() const { return boundaryEdges == 0; }
    /// Closed, and no edge has more than two triangles.
    bool isWatertight() const { return boundaryEdges == 0 && nonManifoldEdges == 0; }
    /// Each edge has an even number of triangles: any line from a point inside crosses an odd
    /// number. Surfaces may touch, and triangles may be there twice, facing both ways.
    bool hasParity() const { return boundaryEdges == 0 && unbalancedEdges == 0; }
    /// Whether the surface is folded flat, within rounding.
    bool enclosesNothing() const {
        const double size = length(bounds.size());
        return !(enclosedVolume > 1e-9 * area * size);
    }
    /// Such as "14 boundary edges, first at vertex 2031 (1.5, -3, 20); largest hole: 10 edges,
    /// 12.3 mm around, at (1, -2, 20)"; empty for a closed mesh.
    std::string describeLeak() const;
    /// Such as "1 pair of components that intersect, in about 19.9 mm³ around (7, 0, 0)".
    std::string describeIntersections() const;
};

/// Examines a welded mesh (welding.h). Cost: linear in the triangles.
MeshHealth checkMesh(const TriangleMesh& mesh);

/// The mesh without duplicate triangles and without triangles that use a vertex twice. Of triangles
/// with the same three vertices the first is kept, so the surface is the same set of points. The
/// vertices do not change.
///
/// Triangles without area but with three different vertices are kept: their neighbors meet at their
/// edges, and without them a closed mesh would have a slit. An edge where only duplicates met is a
/// boundary edge afterwards, and parity of rays and volumes can change: call `checkMesh` and
/// `analyzeShells` first where these matter.
/// @param withCommonWalls  false: of as many triangles that face one way as the other none is kept,
///                         so that solids with a wall in common are one; their volume does not
///                         change.
TriangleMesh withoutDuplicates(const TriangleMesh& mesh, bool withCommonWalls = true);

/// All members by name, lengths in mm; `leak` is null for a closed mesh.
nlohmann::json toJson(const MeshHealth& health);

/// The report for a reader, several lines.
std::string toText(const MeshHealth& health);

}  // namespace vdbpack
