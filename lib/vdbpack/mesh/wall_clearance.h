// Private to mesh and domain: how thick the walls of a closed mesh are, and how far apart.
#pragma once

#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/triangle_mesh.h"

namespace vdbpack {

/// Along the normals of a sample of triangles; lengths in mm, to a factor of 2 below.
struct WallClearance {
    bool isSolid = false;  ///< the inside lies behind the triangles: no part intersects another
    double thickness = 0;  ///< of the thinnest walls (1 % of the area)
    double gap = 0;        ///< between walls, of the narrowest 1 %; infinite if there is none
};

/// @param mesh  closed and welded, its triangles of equal orientation in each shell.
WallClearance wallClearance(const TriangleMesh& mesh, const MeshAnalysis& analysis);

}  // namespace vdbpack
