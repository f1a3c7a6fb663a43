// Surfaces as STL, which every program for solids reads.
#pragma once

#include "vdbpack/core/units.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <string>

namespace vdbpack {

/// Writes a mesh (mm) as binary STL: coordinates in `unit` as 32-bit floats, normals by the order
/// of the corners, outward where that is. The header names unit and `generator`. Whole or absent.
/// @throws ParameterError (a vertex that does not exist or is not finite; more than 2^32 - 1
/// triangles), IoError
void writeStl(const TriangleMesh& mesh, const std::string& file, Unit unit = Unit::millimeter,
              const std::string& generator = {});

}  // namespace vdbpack
