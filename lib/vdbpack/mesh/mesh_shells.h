// The closed pieces of a mesh and which of them lies inside which.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// One connected piece of a mesh (triangles joined by shared edges).
struct Shell {
    std::size_t triangles = 0;
    std::size_t boundaryEdges = 0;  ///< 0 for a closed piece
    double signedVolume = 0;  ///< divergence theorem, mm³; negative if the faces point inward
    int depth = 0;            ///< closed pieces that enclose it; odd: it bounds a cavity
};

struct ShellAnalysis {
    std::vector<std::uint32_t> shellOfTriangle;  ///< index into `shells`, one a triangle
    std::vector<Shell> shells;                   ///< by falling |signedVolume|

    /// Volume enclosed, cavities taken off, whichever way the triangles face, mm³:
    /// the sum of (-1)^depth |signedVolume|.
    double enclosedVolume() const;
};

/// Splits a mesh into its pieces and finds their nesting. `mesh` is welded (mesh_io.h).
/// Cost: a sort of the edges, and rays from one vertex of each piece through the pieces whose
/// bounds contain it.
ShellAnalysis analyzeShells(const TriangleMesh& mesh);

}  // namespace vdbpack
