// Remeshing: a closed surface where the winding number of a triangle soup is 1/2.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

class WindingNumber;

struct Resurfaced {
    TriangleMesh mesh;        ///< closed, every edge of two triangles, facing outward
    double thinArea = 0;      ///< approximate area of walls lost, thinner than a voxel, mm²
    double bridgedShare = 0;  ///< share of the new vertices that lie on no triangle but over holes
};

/// The surface between lattice points inside (winding number of 1/2 or more) and outside.
///
/// Marching cubes. Where an edge of the lattice intersects a triangle of `mesh`, the vertex lies on
/// the triangle, elsewhere where the winding number is 1/2. On a face with two diagonal inside
/// corners, these are separated, so that the surface is closed. Coordinates are rounded to 32 bits
/// if that moves them by less than 0.2 % of a voxel. Only cells that contain triangles or the
/// surface are visited. The same mesh for any number of threads.
///
/// @param mesh       oriented by `turnOutward` (facing.h); `winding` was made from it.
/// @param voxelSize  spacing of the lattice, mm. Smaller details are lost.
/// @throws ResourceError if memory does not suffice, Interrupted once cancelled.
Resurfaced resurface(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
                     const Callbacks& callbacks = {});

}  // namespace vdbpack
