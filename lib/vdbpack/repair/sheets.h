// Private to repair: splits a surface at edges with more than two triangles.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

/// Splits the surface at edges with four or more triangles, so that every edge has two: triangles
/// with the inside between them stay connected. Vertices are duplicated there; no triangle moves.
/// At every edge of `mesh`, as many triangles run along it in one direction as in the other.
/// @return number of split edges.
std::size_t partSheets(TriangleMesh& mesh);

/// The surface split like that, and also at vertices where it only touches itself, so that it is a
/// manifold. Triangles keep their order. Any mesh is allowed: at an edge where the triangles do not
/// cancel, those without a partner get a border.
TriangleMesh manifoldOf(const TriangleMesh& mesh);

}  // namespace vdbpack
