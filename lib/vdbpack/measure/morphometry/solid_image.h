// Solids, of files or of spheres, as images of a domain.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <functional>
#include <string>

namespace vdbpack {

/// Voxels beyond a wall: the distances next to it are known on both sides.
inline constexpr double kWallMargin = 3;
/// Voxels of an image with depths take as much memory as so many others.
inline constexpr double kWalledVoxel = 1.8;

/// Voxels of a solid in a box, with so much of a margin (mm) around it.
using SolidSampler = std::function<VoxelImage(const Box<3>& bounds, double margin)>;

/// A solid in a domain. If more than half of the solid at the wall continues beyond it, the domain
/// counts as cut from a larger sample, and the image reaches a tenth of the shortest side beyond
/// it; else the solid and the pore space end at the wall (`VoxelImage::depth`).
/// @param shell  mm; label 1 is the layer along the wall, label 2 the rest; 0: all is label 1.
VoxelImage imageInDomain(const Domain<3>& domain, double shell, double voxelSize,
                         const SolidSampler& sample);

/// The morphometry of an image; warns of few voxels and of a solid that is not in the total volume.
/// @param subject  for messages.
Morphometry measuredImage(const VoxelImage& image, const std::string& subject,
                          const Callbacks& callbacks);

}  // namespace vdbpack
