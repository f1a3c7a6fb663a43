// Which voxels of an image lie in a domain, and how deep.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/field/voxel_image.h"

namespace vdbpack {

/// Labels voxels by where their centers lie: 0 outside of the domain, 1 inside; with a shell, 1 in
/// the layer of that thickness below the wall of the envelope and 2 deeper. Voxels labeled 0
/// before stay 0.
/// @param walled  set `image.depth`, too, clamped at three voxels.
void labelVoxels(VoxelImage& image, const Domain<3>& domain, const ShellThickness& shell,
                 bool walled = false);

}  // namespace vdbpack
