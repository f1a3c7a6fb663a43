// A closed surface where the winding number of a soup of triangles passes one half.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

class WindingNumber;

struct Resurfaced {
    TriangleMesh mesh;        ///< closed, every edge of two triangles, facing outward
    double thinArea = 0;      ///< of walls thinner than a voxel, which have no inside, mm², about
    double bridgedShare = 0;  ///< share of the new vertices that lie on no triangle: over holes
};

/// The surface between lattice points inside (winding number of 1/2 or more) and outside.
///
/// Marching cubes whose vertices lie on the triangles of `mesh` themselves wherever an edge of the
/// lattice passes through one, and where the winding number is 1/2 elsewhere; at a face with two
/// diagonal inside corners these are kept apart, so that the surface closes. Coordinates are
/// rounded to 32 bits where that moves them by less than 0.2 % of a voxel. Only cells that hold
/// triangles or the surface are visited. The same mesh for any number of threads.
///
/// @param mesh       faces outward as far as can be told (facing.h); what `winding` was made of.
/// @param voxelSize  edge of the lattice's cubes, mm. Corners sharper than that are cut off.
/// @throws ResourceError if memory does not suffice, Interrupted once cancelled.
Resurfaced resurface(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
                     const Callbacks& callbacks = {});

}  // namespace vdbpack
