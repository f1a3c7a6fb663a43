// Private to repair: one repair of all triangles together.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/facing.h"
#include "vdbpack/repair/mesh_repair.h"

namespace vdbpack {

class WindingNumber;

struct WholeRepairOptions {
    NestedShells nested = NestedShells::cavity;
    double voxelSize = 0;       ///< of a remeshed surface, mm; 0: `repairVoxelSize`
    double leastVoxelSize = 0;  ///< the chosen size is at least this, mm
    /// About the number of points at which ambiguous and overlapping volumes are counted.
    double volumePoints = 2e5;
};

struct WholeRepair {
    TriangleMesh mesh;      ///< watertight, normals out of the solid; empty: no point is inside
    TriangleMesh oriented;  ///< the triangles of the file without duplicates, oriented outward
    RepairReport report;    ///< without `changes`
};

/// The repair that `repairMesh` describes (mesh_repair.h). @param mesh  welded, mm.
/// @throws ResourceError if memory does not suffice, Interrupted once cancelled.
WholeRepair repairWhole(TriangleMesh mesh, const WholeRepairOptions& options,
                        const Callbacks& callbacks = {});

/// The surface where the winding number is 1/2 (resurface.h), without components below ten voxels;
/// what was done goes to `report`.
TriangleMesh remesh(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
                    RepairReport& report, const Callbacks& callbacks);

/// Most triangles of a remeshed surface, estimated as two per voxel.
constexpr double kMostRemeshed = 8e5;

/// Default voxel size, mm: three tenths of a typical edge, at most a fifth of the mean wall
/// thickness, and larger where that would take more than `kMostRemeshed`.
double repairVoxelSize(const TriangleMesh& mesh);

}  // namespace vdbpack
