// Volumes that a field of signed distances encloses.
#pragma once

#include <openvdb/openvdb.h>

namespace vdbpack {

/// Number of voxels whose value is negative; a voxel that the surface crosses counts by the share
/// that lies behind a plane at its distance. Walls thinner than a voxel keep about their volume.
/// @param voxelSize  the unit of the values.
double volumeByVoxels(const openvdb::FloatGrid& field, float voxelSize);

/// Volume, in voxels, in which the trilinear interpolant of the values is at most `level`: points
/// that are sampled there by interpolation lie in just this volume. To 1e-3 of a cell and better.
/// @param level  at most the field's depth in front of its clamped values.
double volumeByCells(const openvdb::FloatGrid& field, float level);

}  // namespace vdbpack
