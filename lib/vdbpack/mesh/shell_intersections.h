// Private to mesh: closed shells that pass through each other.
#pragma once

#include "vdbpack/mesh/mesh_shells.h"

#include <cstddef>

namespace vdbpack {

/// Pairs of closed shells of which an edge passes through a triangle of the other one. Shells that
/// only touch do not count.
std::size_t countIntersections(const TriangleMesh& mesh, const ShellAnalysis& analysis);

}  // namespace vdbpack
