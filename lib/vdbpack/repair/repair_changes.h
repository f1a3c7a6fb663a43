// How the components and the topology of a surface differ before and after its repair.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/mesh_repair.h"

#include <cstddef>
#include <cstdint>

namespace vdbpack {

SurfaceTopology topologyOf(const TriangleMesh& mesh);

/// Compares two surfaces. A component before has become the component after that has vertices at
/// most of its corners. Up to about 500 corners per component are looked up.
/// @param before  oriented outward, without collapsed triangles.
/// @param after   closed, oriented outward.
/// @param reach   how far the vertices lie apart at most, mm; 0: they are the same.
RepairChanges compareSurfaces(const TriangleMesh& before, const TriangleMesh& after, double reach);

}  // namespace vdbpack
