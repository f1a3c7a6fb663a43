// Private to mesh: closed shells that pass through each other.
#pragma once

#include "vdbpack/mesh/mesh_shells.h"

namespace vdbpack {

ShellIntersections findIntersections(const TriangleMesh& mesh, const ShellAnalysis& analysis);

}  // namespace vdbpack
