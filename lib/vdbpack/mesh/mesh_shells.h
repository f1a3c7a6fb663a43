// The connected components of a mesh and their nesting.
#pragma once

#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

class EdgeTable;

/// A connected component of a mesh (triangles connected by shared edges).
struct Shell {
    std::size_t triangles = 0;
    std::size_t boundaryEdges = 0;  ///< 0: closed
    double signedVolume = 0;  ///< divergence theorem, mm³; negative if the triangles face inward
    int depth = 0;            ///< number of closed shells that enclose it; odd: it bounds a cavity
};

struct ShellAnalysis {
    std::vector<std::uint32_t> shellOfTriangle;  ///< index into `shells`, one per triangle
    std::vector<Shell> shells;                   ///< by decreasing |signedVolume|

    /// Enclosed volume without cavities, for any orientation of the triangles, mm³:
    /// the sum of (-1)^depth |signedVolume|.
    double enclosedVolume() const;
};

/// Splits a mesh into shells and finds their nesting. `mesh` is welded (welding.h). Duplicate
/// triangles are allowed: where every edge has an even number of triangles, the parity of rays is
/// right.
///
/// Where more than two triangles meet at an edge, those with the inside between them belong to one
/// shell if as many run along it one way as the other, and all of them otherwise: solids that touch
/// at an edge are separate. Solids with a wall in common, of which each has a copy, are one shell
/// if the copies face opposite ways. So are a shell and one inside it that faces outward and shares
/// an edge with it, as the two may overlap. Shells that share only a vertex are separate. A
/// triangle that uses a vertex twice belongs to a shell at one of its corners and does not affect
/// it. Only closed shells enclose others. Where two shells intersect, the smaller counts as
/// enclosed if more than three quarters of up to five of its triangles lie inside the larger.
///
/// Cost: linear in the triangles, except for rays (along z) from five triangles of each shell.
/// Volumes are computed relative to a point of the shell, so they lose no digits far from the
/// origin. The volume of an open shell is computed with every hole closed by a cone from the
/// centroid of its boundary (exact for plane holes).
ShellAnalysis analyzeShells(const TriangleMesh& mesh);
/// The same with an existing table of the edges of `mesh`.
ShellAnalysis analyzeShells(const TriangleMesh& mesh, const EdgeTable& edges);

/// The health of a mesh and the shells that it was found by.
struct MeshAnalysis {
    MeshHealth health;
    ShellAnalysis shells;
};
/// Both for the cost of `checkMesh` (mesh_check.h).
/// @param isContour  of a level set or an image: whether its shells intersect is not looked for.
MeshAnalysis analyzeMesh(const TriangleMesh& mesh, bool isContour = false);

/// The shells of a mesh that lie in no other closed one.
TriangleMesh outermostShells(const TriangleMesh& mesh, const ShellAnalysis& shells);

}  // namespace vdbpack
