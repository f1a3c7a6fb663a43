// Private: a mesh on the lattice of a grid.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/mesh/triangle_mesh.h"

namespace vdbpack {

/// Voxel (i, j, k) has its center at `origin` + (i, j, k) * `voxelSize`.
struct LatticeMesh {
    const TriangleMesh& mesh;
    Vec<3> origin;
    double voxelSize = 1;
};

}  // namespace vdbpack
