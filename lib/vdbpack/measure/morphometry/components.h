// Private to measure: the connected components of the solid of a voxel image.
#pragma once

#include "vdbpack/field/voxel_image.h"

#include <optional>

namespace vdbpack {

/// Share of the solid voxels of the total volume that its largest connected component has, up to 1;
/// nothing without solid. Voxels are connected through faces, edges and corners (26 neighbors), as
/// for the Euler number, and only through the total volume.
///
/// The runs of solid voxels along x are joined with those of the four rows before. Exact, and the
/// same for any number of threads. Cost: 1.7 ns a voxel on two threads (14 ms for 200³ voxels of
/// BV/TV 0.16), and 28 bytes a run.
std::optional<double> largestComponentShare(const VoxelImage& image);

}  // namespace vdbpack
