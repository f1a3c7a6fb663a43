// Triangle meshes from files.
#pragma once

#include "vdbpack/core/units.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <string>

namespace vdbpack {

struct MeshReadOptions {
    Unit unit = Unit::millimeter;  ///< of the lengths in the file
    double scale = 1;              ///< a further factor on all coordinates, > 0
};

/// What a file held before welding.
struct MeshFileFacts {
    std::string format;        ///< "binary STL", "ASCII PLY", ...
    std::size_t bytes = 0;     ///< size of the file
    std::size_t vertices = 0;  ///< corners of triangles where the format has no vertices (STL)
    std::size_t faces = 0;     ///< polygons
    std::size_t mergedVertices = 0;  ///< that had the coordinates of an earlier one
    std::size_t unusedVertices = 0;  ///< that no face names
    bool singlePrecision = false;    ///< coordinates are stored as 32-bit floats
    std::size_t crossedFaces = 0;    ///< polygons whose outline crosses itself
    Vec<3> crossedAt;                ///< first corner of the first of them, mm
};

/// Reads a mesh from .stl (binary or ASCII, told apart by content), .obj, .ply (ASCII or binary
/// of either byte order), .off, .vtp (polygon data of VTK) or .vtk (its legacy format); other
/// extensions are refused.
///
/// Coordinates keep all digits that the file holds and come back in mm. Vertices with identical
/// coordinates are merged (-0 equals 0), those that no face names dropped; what remains keeps its
/// order. Polygons are cut into triangles as by `splitPolygon`. Triangles are not judged: those
/// that are duplicate or have no area stay (mesh_check.h).
///
/// @param facts  filled in if given.
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
                      MeshFileFacts* facts = nullptr);

}  // namespace vdbpack
