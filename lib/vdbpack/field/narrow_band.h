// Private: distances to a triangle mesh in a narrow band of voxels.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// A mesh on the lattice of a grid; voxel (i, j, k) has its center at `origin` + (i, j, k) *
/// `voxelSize`. All arithmetic is in double relative to `origin`, so that a mesh far from zero
/// loses no digits.
struct LatticeMesh {
    const TriangleMesh& mesh;
    Vec<3> origin;
    double voxelSize = 1;
};

/// Which way each triangle faces: 1 out of the solid, -1 into it, 0 unknown. Unknown costs time
/// (the wider band is made on both sides), not exactness; a wrong one leaves voxels out.
using Facing = std::vector<std::int8_t>;

/// Exact signed distances to a closed mesh, mm, negative inside: active to `inside` voxels inside
/// and `outside` voxels outside, the background.
///
/// Inside is where an odd number of surfaces lies below: shells within shells bound cavities,
/// whichever way they face. The distance is that to the nearest point of the nearest triangle, to
/// 1e-5 voxel; the sign is right for all voxels that are farther than this from the surface. The
/// same bits for any number of threads. Degenerate and duplicate triangles are allowed; those that
/// name a vertex twice do not count.
///
/// Each triangle, edge and vertex is compared with the voxels that it may be nearest to: triangles
/// with the prism over them, edges with the wedge between their triangles, vertices with the polar
/// cone of their edges. Signs are crossings counted by an exact rasterization along z.
/// @param lattice  each edge of the mesh has an even number of triangles; surfaces do not cross one
/// another.
/// @param facing   of each triangle; empty: all unknown.
/// @throws ResourceError for a lattice of more than 2^32 columns, 2^31 nodes or 10^9 voxels along
///         an axis; Interrupted; std::bad_alloc.
openvdb::FloatGrid::Ptr narrowBand(const LatticeMesh& lattice, float inside, float outside,
                                   const Facing& facing = {}, const Callbacks& callbacks = {});

}  // namespace vdbpack
