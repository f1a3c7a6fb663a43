// The closed pieces of a mesh and which of them lies inside which.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

class EdgeTable;

/// One connected piece of a mesh (triangles joined by shared edges).
struct Shell {
    std::size_t triangles = 0;
    std::size_t boundaryEdges = 0;  ///< 0 for a closed piece
    double signedVolume = 0;  ///< divergence theorem, mm³; negative if the faces point inward
    int depth = 0;            ///< closed pieces that enclose it; odd: it bounds a cavity
};

struct ShellAnalysis {
    std::vector<std::uint32_t> shellOfTriangle;  ///< index into `shells`, one per triangle
    std::vector<Shell> shells;                   ///< by falling |signedVolume|

    /// Volume enclosed without cavities, whichever way the triangles face, mm³:
    /// the sum of (-1)^depth |signedVolume|.
    double enclosedVolume() const;
};

/// Splits a mesh into its pieces and finds their nesting. `mesh` is welded (welding.h). Duplicate
/// triangles may stay: where every edge has an even number of triangles, rays count right.
///
/// Triangles at an edge shared by three or more are one piece; a piece that touches another in a
/// vertex only is a piece of its own. A triangle that names a vertex twice belongs to a piece at
/// one of its corners and changes nothing there. Only closed pieces enclose others; of pieces
/// that cut through each other, the smaller counts as enclosed if most of up to five of its
/// triangles lie inside the larger.
///
/// Cost: linear in the triangles, except for rays (along z) from five triangles of each piece.
/// Volumes are computed about a point of their own piece and so keep their digits far from zero.
/// The volume of an open piece is that of the piece with every hole closed by a cone to the middle
/// of its edge (exact for plane holes), wherever the mesh lies.
ShellAnalysis analyzeShells(const TriangleMesh& mesh);
/// The same where the table of the mesh's edges exists already.
ShellAnalysis analyzeShells(const TriangleMesh& mesh, const EdgeTable& edges);

}  // namespace vdbpack
