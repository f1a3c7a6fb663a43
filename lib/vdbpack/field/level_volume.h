// Volumes that a field of signed distances encloses.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

namespace vdbpack {

/// Number of voxels whose value is negative; a voxel that the surface crosses counts by the share
/// that lies behind a plane at its distance. Walls thinner than a voxel keep about their volume.
/// @param voxelSize  the unit of the values.
double volumeByVoxels(const openvdb::FloatGrid& field, float voxelSize);

/// Volume, in voxels, in which the trilinear interpolant of the values is at most each of `levels`:
/// points that are sampled there by interpolation lie in just this volume. To 1e-3 of a cell and
/// better.
/// @param levels  descending; within the field's depth, where its values are not clamped.
std::vector<double> volumesByCells(const openvdb::FloatGrid& field,
                                   const std::vector<float>& levels);

}  // namespace vdbpack
