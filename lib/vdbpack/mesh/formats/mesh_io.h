// Triangle meshes from files, and as STL.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/units.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

struct MeshReadOptions {
    Unit unit = Unit::millimeter;  ///< of the lengths in the file, unless its header states one
    double scale = 1;              ///< a further factor on all coordinates, > 0
    /// Axes of the coordinates that come back, where the file states its own.
    ImageSpace space = ImageSpace::lps;
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
/// that are duplicate or have no area stay (mesh_check.h). SPACE=RAS or SPACE=LPS in a header,
/// title or comment among the first 1000 bytes, or in the field data of a .vtp (3D Slicer), states
/// the axes; x and y change their signs where `options.space` is the other one.
///
/// @param callbacks  is warned of that, of the centimeters that Maya states in a .obj, and of
///                   polygons whose outlines cross themselves.
/// @param groups  filled in if given.
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
                      const Callbacks& callbacks = {}, MeshGroups* groups = nullptr);

/// The mesh (mm) in 32-bit floats of `unit`, as `writeStl` writes them, each vertex rounded to the
/// outer side of the triangles at it: what lies within the mesh lies within the result. `mesh` is
/// closed and welded; its components may face either way.
TriangleMesh roundedOutward(TriangleMesh mesh, Unit unit);

/// Writes a mesh (mm) as binary STL: coordinates in `unit` as 32-bit floats, normals by the order
/// of the corners, outward where that is. The header names unit and `generator`. Whole or absent.
/// @throws ParameterError (a vertex that does not exist or is not finite; more than 2^32 - 1
/// triangles), IoError
void writeStl(const TriangleMesh& mesh, const std::string& file, Unit unit = Unit::millimeter,
              const std::string& generator = {});

}  // namespace vdbpack
