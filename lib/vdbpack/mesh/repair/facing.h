// Triangles turned so that a surface faces outward everywhere.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>

namespace vdbpack {

/// What closed surfaces inside others mean.
enum class NestedShells {
    cavity,  ///< they bound cavities, and what is nested in those is solid again
    solid    ///< nothing: all inside the outermost is solid
};

/// Turns triangles so that neighbors agree and the surface faces outward; cavities face into
/// themselves, where nested shells bound any. `mesh` is welded, without collapsed triangles.
///
/// Triangles connected by edges that join exactly two form patches; a patch takes the side that
/// most of its area has in the file. At edges of more triangles a patch is turned where then more
/// of its edges balance. What is nearly closed faces by the sign of its volume and by what lies
/// around it; other pieces follow the surface near them, where the winding number of what is
/// nearly closed changes across them, and the file where it does not.
///
/// Cost: linear in the triangles, but for winding numbers at the pieces that are open.
/// @return how many triangles face the other way now.
std::size_t turnOutward(TriangleMesh& mesh, NestedShells nested = NestedShells::cavity);

}  // namespace vdbpack
