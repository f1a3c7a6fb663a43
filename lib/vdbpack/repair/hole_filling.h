// Closes holes of a surface by triangles between the vertices of their boundary.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

struct HoleFilling {
    std::size_t filled = 0;  ///< number of filled holes
    double area = 0;         ///< of the added triangles, mm²
    std::size_t left = 0;    ///< holes not filled: more than 1000 edges, or a tangled boundary
};

/// Adds triangles that close the holes of a consistently oriented mesh (facing.h).
///
/// A boundary that touches itself in a vertex is split there into several holes, as if the surface
/// at that vertex were flat. Each hole is filled by the triangulation of least area (Barequet and
/// Sharir 1995, doi:10.1016/0167-8396(94)00011-G), oriented as its neighbors.
///
/// Cost: the third power of the number of edges of a boundary.
HoleFilling fillHoles(TriangleMesh& mesh);

}  // namespace vdbpack
