// Consistent outward orientation of the triangles of a mesh.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/mesh_repair.h"

#include <cstddef>
#include <vector>

namespace vdbpack {

struct ShellAnalysis;

/// Orients triangles so that neighbors agree and normals point out of the solid: outward, and into
/// the cavities that nested shells bound. `mesh` is welded, without collapsed triangles.
///
/// 1. Triangles connected by edges with exactly two triangles form patches. A patch gets the
///    orientation that most of its area has in the file.
/// 2. At edges with more triangles, a patch is flipped if this balances more of its edges.
/// 3. A nearly closed shell is oriented by the sign of its volume and, as a cavity, by the shells
///    around it.
/// 4. An open shell is oriented by the change of the winding number of the nearly closed shells
///    across it; where that hardly changes, its orientation stays.
///
/// Cost: linear in the triangles, plus winding numbers at up to about 64 triangles per shell.
/// @return number of flipped triangles.
std::size_t turnOutward(TriangleMesh& mesh, NestedShells nested = NestedShells::cavity);

/// [s] is 1 if shell s has an inside: it is closed, or cones over its holes have less than a
/// quarter of its area. Then the sign of its volume shows which way it faces. @param shells  of
/// `mesh`.
std::vector<char> nearlyClosed(const TriangleMesh& mesh, const ShellAnalysis& shells);

}  // namespace vdbpack
