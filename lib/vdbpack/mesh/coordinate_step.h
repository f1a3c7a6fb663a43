// Digits that the file of a mesh has lost.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

namespace vdbpack {

/// The step in which the coordinates of a mesh come, as far as they show one: the spacing of 32-bit
/// floats where all are such numbers, or the largest power of ten that all are multiples of.
/// @param unit  what the coordinates were multiplied by when they were read.
/// @return in the unit of the mesh; 0 where there is neither (double precision).
double coordinateStep(const TriangleMesh& mesh, double unit);

/// Length of the middle edge by length, of 10,000 triangles at the most; 0 for an empty mesh.
double medianEdge(const TriangleMesh& mesh);

}  // namespace vdbpack
