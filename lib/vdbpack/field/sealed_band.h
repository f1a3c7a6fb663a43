// Private: the narrow band of a mesh by OpenVDB, whether the mesh is closed or not.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// A mesh on a lattice: voxel (i, j, k) has its center at `origin` + (i, j, k) * `voxelSize`.
struct LatticeMesh {
    const TriangleMesh& mesh;
    Vec<3> origin;
    double voxelSize = 1;
};

/// Signed distances to the chosen triangles of a mesh (all, if empty) on a lattice about zero, by
/// OpenVDB's `meshToVolume`: inside is what its flood from outside does not reach, so that holes
/// smaller than voxels are closed and shells within shells are ignored.
///
/// Some 1 % of the values are wrong by up to a voxel, and so are signs next to them; vertices are
/// rounded to 32 bits, in voxels. Without OpenVDB's smoothing of values, which makes ten times as
/// many too deep by more than 0.01 voxel.
/// @throws Interrupted, std::bad_alloc
openvdb::FloatGrid::Ptr sealedBand(const LatticeMesh& mesh,
                                   const std::vector<std::uint32_t>& chosen, float inside,
                                   float outside, const Callbacks& callbacks);

/// Distances without sign, `width` voxels on both sides: of open meshes as well.
openvdb::FloatGrid::Ptr unsignedBand(const LatticeMesh& mesh, float width,
                                     const Callbacks& callbacks);

}  // namespace vdbpack
