// Private to measure: the largest ball in a phase that covers each of its voxels.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/surface_distance.h"

#include <vector>

namespace vdbpack {

enum class Phase { solid, pores };

/// Local thickness at the voxels of one phase in the total volume: the diameter in voxels of the
/// largest ball that holds the voxel's center, is centered in the image and does not reach through
/// the surface. Neither the rim of the image nor that of the total volume stops a ball.
///
/// Source: Hildebrand, Rueegsegger (1997), doi:10.1046/j.1365-2818.1997.1340694.x. Where they and
/// Dougherty and Kunzelmann (2007), doi:10.1017/S1431927607074430, center balls on voxels, each
/// voxel of the distance ridge is moved here: away from its surface point, at which the ball
/// grows as fast as it moves, up to where a surface point of a neighboring voxel stops it, then
/// away from both. That gives the middle and the radius of slabs and rods to a few hundredths of a
/// voxel wherever they lie. Voxels that no ball covers (rims between balls) take the mean of
/// their neighbors.
///
/// @param surface    of `image`, not empty.
/// @param thickness  one value a voxel; voxels of the phase are set.
/// The same for any number of threads. Cost: about 0.2 microseconds a voxel on two threads.
void paintThickness(const VoxelImage& image, const SurfaceDistance& surface, Phase phase,
                    std::vector<float>& thickness);

}  // namespace vdbpack
