// Private to repair: each surface component is repaired on its own.
#pragma once

#include "vdbpack/repair/whole_repair.h"

namespace vdbpack {

/// Repairs each surface component by itself, so that bones which lie close or touch stay apart.
///
/// Components are connected by edges; at an edge with more than two triangles, those with the
/// inside between them (sheets.h). Open components that share a vertex are one. Components without
/// an inside are removed. Then
/// - those that intersect are repaired together, which fuses them,
/// - those inside others bound cavities or are removed, as `nested` says,
/// - the others stay apart, with vertices of their own, also where they touch.
///
/// Parameters and errors as `repairWhole`.
WholeRepair repairComponents(TriangleMesh mesh, const WholeRepairOptions& options,
                             const Callbacks& callbacks = {});

}  // namespace vdbpack
