// Private to measure and to runs: what the border of the total volume cuts.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/morphometry.h"

namespace vdbpack {

/// By the voxel faces between the total volume and the rest, those of the image included.
/// The solid counts as continuing where the next two voxels beyond such a face are solid.
BorderShares borderShares(const VoxelImage& image);

}  // namespace vdbpack
