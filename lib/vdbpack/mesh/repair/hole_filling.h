// Holes of a surface closed by triangles between the vertices of their rims.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

struct HoleFilling {
    std::size_t filled = 0;     ///< holes
    std::size_t triangles = 0;  ///< that close them
    double area = 0;            ///< of those triangles, mm²
    double largest = 0;         ///< longest rim of a filled hole, mm
    std::size_t left = 0;       ///< holes that stay: rims of more than 1000 edges, or tangled ones
};

/// Adds triangles that close the holes of a mesh whose triangles face alike (facing.h).
///
/// A rim that touches itself is parted there into holes of their own, the surface at the vertex
/// being taken for flat. Each hole gets the triangles of least area that its rim allows (Barequet
/// and Sharir 1995, doi:10.1016/0167-8396(94)00011-G), which face as their neighbors do.
///
/// Cost: the third power of the edges of a rim.
HoleFilling fillHoles(TriangleMesh& mesh);

}  // namespace vdbpack
