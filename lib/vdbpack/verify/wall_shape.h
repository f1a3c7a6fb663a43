// Walls to check against: pieces of meshes, and shapes given by numbers, cut by planes.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <optional>
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

/// Depth of `x` below the nearest of some planes, mm; negative beyond one, infinite for none.
template <int Dim>
double innerDistance(const std::vector<HalfSpace<Dim>>& clips, const Vec<Dim>& x);

/// A wall given by numbers; independent of `Domain`, which it checks.
template <int Dim>
struct WallShape {
    enum class Kind { box, ball, cylinder };

    Kind kind = Kind::box;
    Box<Dim> box;                       ///< kind box
    std::array<bool, Dim> wraps{};      ///< kind box: axes along which it has no walls
    Vec<Dim> center;                    ///< kind ball, cylinder; mm
    double radius = 0;                  ///< kind ball, cylinder; mm
    double height = 0;                  ///< kind cylinder (3D, about z through `center`); mm
    std::vector<HalfSpace<Dim>> clips;  ///< further cuts

    static WallShape ofBox(const Box<Dim>& box);
    static WallShape ofBall(double radius, const Vec<Dim>& center = {});
    static WallShape ofCylinder(double radius, double height, const Vec<Dim>& center = {});

    /// Distance to the nearest wall for a point inside, mm; negative outside (there exact for a
    /// box, a ball and a cylinder, and at most the true distance in size once clipped).
    double innerDistance(const Vec<Dim>& x) const;
};

/// The plane z = `height` of a shape; nothing if the plane misses it.
std::optional<WallShape<2>> sliceShape(const WallShape<3>& shape, double height);

}  // namespace vdbpack
