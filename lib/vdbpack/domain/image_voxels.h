// Private to domain and runs: voxels of an image that belong to a solid, and images with a rim.
#pragma once

#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/image/image.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// 1 at each voxel that a recipe selects by its labels or its threshold, else 0.
/// @throws ParameterError if it selects nothing that there is, or several parts.
std::vector<std::uint8_t> solidVoxels(const DomainRecipe& recipe, const Image& image);

/// The image with `rim` further voxels on all sides, each with the value of the nearest voxel, so
/// that what the border cuts continues beyond it. @throws ResourceError
Image withRim(const Image& image, std::size_t rim);

/// Makes solid what is solid in the voxels of an image: distances of another sign become half a
/// voxel. @param solid  of `solidVoxels`, on `grid`.
void takeVoxels(const std::vector<std::uint8_t>& solid, const ImageGrid& grid, VoxelImage& voxels);

}  // namespace vdbpack
