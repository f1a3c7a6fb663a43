// The principal axes of what a mesh encloses.
#pragma once

#include "vdbpack/core/principal_axes.h"
#include "vdbpack/mesh/mesh_shells.h"

#include <optional>

namespace vdbpack {

/// Of the volume inside, without cavities, for any orientation of the triangles; nothing for a mesh
/// that is not closed or encloses nothing. Exact to rounding.
std::optional<PrincipalAxes<3>> principalAxes(const TriangleMesh& mesh,
                                              const MeshAnalysis& analysis);

}  // namespace vdbpack
