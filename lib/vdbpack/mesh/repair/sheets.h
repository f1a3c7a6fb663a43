// Private to repair: sheets of a surface that meet at edges of more than two triangles.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

/// Parts the sheets that meet at edges of four triangles or more, so that every edge has two:
/// triangles with the inside between them stay together. Vertices are doubled where sheets part;
/// no triangle moves. Every edge of `mesh` has as many triangles one way as the other.
/// @return edges that were parted.
std::size_t partSheets(TriangleMesh& mesh);

}  // namespace vdbpack
