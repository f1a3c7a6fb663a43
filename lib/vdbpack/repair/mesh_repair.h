// A watertight surface from a mesh with holes, inverted or duplicate triangles, or overlaps.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/repair_report.h"

#include <string>

namespace vdbpack {

/// The meaning of closed shells inside others.
enum class NestedShells {
    cavity,  ///< they bound cavities; shells inside a cavity are solid again
    solid    ///< they are ignored: everything inside the outermost shell is solid
};

struct RepairOptions {
    RepairComponents components = RepairComponents::together;
    NestedShells nested = NestedShells::cavity;
    /// Voxel size where the surface is remeshed, mm; 0: chosen (whole_repair.h).
    double voxelSize = 0;
    std::string name = "mesh";  ///< in messages
};

struct RepairedMesh {
    TriangleMesh mesh;  ///< watertight; normals point out of the solid
    RepairReport report;
};

/// Makes a mesh watertight. The inside is where the generalized winding number of the triangles,
/// oriented outward, is at least 1/2 (Jacobson et al. 2013, doi:10.1145/2461912.2461916).
///
/// The triangles of the file are kept if possible: duplicates are removed, inverted triangles are
/// oriented, small holes are filled, and triangles inside the solid are removed. If the result is
/// not a closed surface that agrees with the winding number of the open one (large holes,
/// components that intersect), the surface is remeshed on a lattice, with vertices on the
/// triangles of the file. A mesh without defects is returned unchanged.
///
/// Deterministic, and the same for any number of threads, so that a pack can be verified later
/// against the file repaired again.
///
/// @param mesh  welded (welding.h), mm.
/// @throws InputError if no point is inside. ParameterError for a negative voxel size.
/// ResourceError if memory does not suffice, Interrupted once cancelled.
RepairedMesh repairMesh(TriangleMesh mesh, const RepairOptions& options = {},
                        const Callbacks& callbacks = {});

/// Both surfaces in one mesh, `inner` as the wall of a cavity in `outer`, which encloses it.
TriangleMesh joinedAsCavity(TriangleMesh outer, TriangleMesh inner);

/// The inside of `outer` without the inside of `inner`, where the two intersect: a remeshed surface
/// (resurface.h). Both are watertight, as `repairMesh` returns them. @throws as `repairMesh`
RepairedMesh subtractMesh(const TriangleMesh& outer, const TriangleMesh& inner,
                          const RepairOptions& options = {}, const Callbacks& callbacks = {});

}  // namespace vdbpack
