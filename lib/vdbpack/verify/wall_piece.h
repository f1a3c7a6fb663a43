// Pieces of walls: triangles in space, segments in the plane.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <vector>

namespace vdbpack {

/// A triangle (2D: a segment) by its corners, mm; orientation does not matter.
template <int Dim>
using WallPiece = std::array<Vec<Dim>, static_cast<std::size_t>(Dim)>;

/// The triangles of a mesh. @throws InputError for indices out of range.
std::vector<WallPiece<3>> wallPieces(const TriangleMesh& mesh);

/// Where the plane z = `height` cuts a mesh: closed curves if the mesh is closed. Triangles that
/// lie in the plane count as below it. @throws InputError for indices out of range.
std::vector<WallPiece<2>> sliceSegments(const TriangleMesh& mesh, double height);

template <int Dim>
Box<Dim> boxOf(const WallPiece<Dim>& piece) {
    Box<Dim> bounds;
    for (const auto& p : piece) bounds.add(p);
    return bounds;
}

}  // namespace vdbpack
