// Private: distances to a triangle mesh in a narrow band of voxels.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Triangles on the lattice of a grid; voxel (i, j, k) has its center at `origin` + (i, j, k) *
/// `voxelSize`. All arithmetic is in double, so that a mesh far from zero loses no digits.
struct LatticeMesh {
    const TriangleMesh& mesh;
    std::vector<std::uint32_t> chosen;  ///< triangles; all, if empty
    Vec<3> origin;
    double voxelSize = 1;
};

/// Signed distances to the nearest triangle, mm about the origin, negative inside: to `inside`
/// voxels on one side and `outside` voxels on the other.
///
/// Without OpenVDB's smoothing of values, which makes them too deep by more than 0.01 voxel in ten
/// times as many voxels.
/// @throws Interrupted, std::bad_alloc
openvdb::FloatGrid::Ptr narrowBand(const LatticeMesh& triangles, float inside, float outside,
                                   const Callbacks& callbacks);

/// Distances without sign, `width` voxels on both sides: of open meshes as well.
openvdb::FloatGrid::Ptr unsignedBand(const LatticeMesh& triangles, float width,
                                     const Callbacks& callbacks);

}  // namespace vdbpack
