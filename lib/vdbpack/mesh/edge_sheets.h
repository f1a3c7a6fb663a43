// Which triangles continue one another across an edge with more than two. Private to mesh and
// repair.
#pragma once

#include "vdbpack/mesh/edge_table.h"

#include <functional>

namespace vdbpack {

/// Pairs the triangles at an edge that have the inside between them, going around it: inside begins
/// behind one triangle and ends behind another, and the innermost two are paired first. Of
/// triangles that coincide, that which ends an inside comes before that which begins one, so that
/// solids with a wall in common are apart. Triangles that find no partner are left out.
///
/// @param lower, upper, first, last  an edge of `edges` and its uses (`EdgeTable::forEach`).
/// @param join  is called with each pair.
void pairSheets(const TriangleMesh& mesh, const EdgeTable& edges, std::uint32_t lower,
                std::uint32_t upper, const EdgeTable::Use* first, const EdgeTable::Use* last,
                const std::function<void(const EdgeTable::Use&, const EdgeTable::Use&)>& join);

}  // namespace vdbpack
