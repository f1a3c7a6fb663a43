// Private to measure and to runs: the union of spheres as voxels.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/field/voxel_image.h"

#include <vector>

namespace vdbpack {

/// The union of spheres whose radii are increased by `dilation`, as a solid.
///
/// Distances are those to the nearest of the spheres: exact outside of the union, and inside up to
/// where the surfaces of two spheres meet, there up to a voxel too small in amount.
/// @param dilation   mm, >= 0; spheres in contact get a neck of radius about sqrt(2 r dilation).
/// @param bounds     total volume, mm; voxels fill it from its low corner.
/// @param margin     mm; voxels this far beyond `bounds` are added with label 0.
/// @throws ParameterError for an unusable dilation or size, ResourceError as `emptyImage`.
VoxelImage sphereImage(const std::vector<Sphere<3>>& spheres, double dilation, const Box<3>& bounds,
                       double voxelSize, double margin);

}  // namespace vdbpack
