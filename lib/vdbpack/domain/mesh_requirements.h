// Private to domain and run: requirements of a mesh and its voxels, and the messages if they are
// not met.
#pragma once

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/vdb_field.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/wall_clearance.h"

#include <string>

namespace vdbpack {

/// @throws ParameterError for lengths that are negative or not finite.
void requireLengths(const FieldOptions& options);

/// @throws InputError for a mesh without triangles, or with unusable vertices or indices.
void requireUsableMesh(const TriangleMesh& mesh, const std::string& name);

/// Estimate of the active voxels of a field. @param area  of the wall, mm².
double estimatedVoxels(double area, double voxelSize, double depth);

/// Refuses voxel sizes that can only result from a wrong unit.
/// @throws ParameterError if voxels are larger than the mesh, ResourceError if there are too many.
void requireVoxels(const std::string& name, const TriangleMesh& mesh, double area, double voxelSize,
                   double depth);

/// Refuses, before its field is built, a mesh that is far thinner than the voxels of that field, or
/// that is no surface but loose triangles. @throws InputError
void requireVolume(const std::string& name, const MeshHealth& health, double voxelSize);

/// Whether a field of the mesh can be all that the mesh encloses: it is closed, and no triangles
/// face the wrong way or reach into other components. Components may touch at edges.
bool isSound(const MeshHealth& health);

/// Whether every edge has two triangles of equal orientation and no components intersect, so that
/// the mesh has a volume.
bool isClean(const MeshHealth& health);

/// Whether the triangles alone tell what a mesh encloses: it is clean, or its components touch, or
/// overlap by no more than rounding makes them.
bool hasVolume(const MeshHealth& health);

/// The defects of a mesh that is not clean, for a message.
std::string flawsOf(const MeshHealth& health);

/// Refuses a mesh whose field encloses another volume than the mesh. @throws InputError always.
[[noreturn]] void refuseMesh(const std::string& name, const MeshHealth& health, double fieldVolume,
                             double voxelSize);

/// Refuses voxels that walls or gaps of the mesh are too thin for, in a message with a size that is
/// small enough.
/// @throws InputError always.
[[noreturn]] void refuseVoxels(const std::string& name, const MeshHealth& health,
                               double fieldVolume, double voxelSize, const WallClearance& clearance,
                               double fineEnough);

/// What a field needs to know of the shells of a mesh.
MeshNesting nestingOf(const MeshAnalysis& analysis);

}  // namespace vdbpack
