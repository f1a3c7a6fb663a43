// Triangle meshes from files, and as STL.
#pragma once

#include "vdbpack/core/units.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

struct MeshReadOptions {
    Unit unit = Unit::millimeter;  ///< of the lengths in the file, unless its header states one
    double scale = 1;              ///< a further factor on all coordinates, > 0
};

/// Polygons of a file whose outline crosses itself.
struct CrossedFaces {
    std::size_t count = 0;
    Vec<3> firstAt;  ///< first corner of the first of them, mm
};

/// Names in a file, `solid` of an ASCII .stl, `o` and `g` of an .obj: each with the first triangle
/// that has it. A name may come several times.
using MeshGroups = std::vector<std::pair<std::string, std::size_t>>;

/// Reads a mesh from .stl (binary or ASCII, told apart by content), .obj, .ply (ASCII or binary
/// of either byte order), .off, .gts, .vtp (polygon data of VTK) or .vtk (its legacy format); other
/// extensions are refused.
///
/// Coordinates keep all digits that the file holds and come back in mm. Vertices with identical
/// coordinates are merged (-0 equals 0), those that no face names dropped; what remains keeps its
/// order. Polygons are cut into triangles as by `splitPolygon`. Triangles are not judged: those
/// that are duplicate or have no area stay (mesh_check.h).
///
/// @param crossed, groups  filled in if given.
/// @throws ParameterError  if `options.scale` is not finite and positive.
/// @throws IoError         if the file does not exist or cannot be read.
/// @throws InputError      if the format is unknown, or the content is broken, truncated, without
///                         triangles, not finite, beyond 10^9 mm, or names vertices that do not
///                         exist; the message names the line or byte.
/// @throws ResourceError   if memory does not suffice.
///
/// Cost: linear in the file, which is read in pieces; nothing is reserved on the word of a count
/// that the file is too small for.
TriangleMesh readMesh(const std::string& path, const MeshReadOptions& options = {},
                      CrossedFaces* crossed = nullptr, MeshGroups* groups = nullptr);

/// Writes a mesh (mm) as binary STL: coordinates in `unit` as 32-bit floats, normals by the order
/// of the corners, outward where that is. The header names unit and `generator`. Whole or absent.
/// @throws ParameterError (a vertex that does not exist or is not finite; more than 2^32 - 1
/// triangles), IoError
void writeStl(const TriangleMesh& mesh, const std::string& file, Unit unit = Unit::millimeter,
              const std::string& generator = {});

}  // namespace vdbpack
