// Private to views: surfaces with fewer triangles.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

/// The mesh with at most `mostTriangles`, to look at: vertices in the same cell of a grid become
/// one, in their middle (those nearest to it, where there are not too many). A mesh that has no
/// more is returned as it is. Source: Rossignac, Borrel (1993), vertex clustering.
TriangleMesh coarsened(const TriangleMesh& mesh, std::size_t mostTriangles);

}  // namespace vdbpack
