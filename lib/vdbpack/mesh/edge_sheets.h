// Which triangles continue one another across an edge with more than two. Private to mesh and
// repair.
#pragma once

#include "vdbpack/mesh/edge_table.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// What becomes of two triangles that coincide and face opposite ways, as where solids have a wall
/// in common.
enum class CommonWalls {
    apart,   ///< each bounds a solid of its own
    cancel,  ///< nothing is between them: the solids are one
};

/// Two triangles at an edge with the inside between them.
struct SheetPair {
    EdgeTable::Use begin, end;
    bool isWall = false;  ///< they coincide, and cancel
};

/// Pairs the triangles at an edge, going around it: inside begins behind one triangle and ends
/// behind another, and the innermost two are paired first. Triangles that find no partner are left
/// out.
///
/// @param lower, upper, first, last  an edge of `edges` and its uses (`EdgeTable::forEach`).
std::vector<SheetPair> pairSheets(const TriangleMesh& mesh, const EdgeTable& edges,
                                  std::uint32_t lower, std::uint32_t upper,
                                  const EdgeTable::Use* first, const EdgeTable::Use* last,
                                  CommonWalls walls);

}  // namespace vdbpack
