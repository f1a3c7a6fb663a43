// Grey values of an image within spheres.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/image/image.h"

#include <vector>

namespace vdbpack {

/// The mean of an image over each ball, in the world of its grid: of the voxels whose centers lie
/// in the ball; for balls that have fewer than 20 of them, of values interpolated between voxels
/// at 100 points spread over the ball. Beyond the border, the values are those at the border.
///
/// @return NaN for balls that do not meet the image.
/// @throws InputError for an image with several values at each voxel, or for an unusable sphere.
/// Cost: about 1 ns a voxel in a ball, 2 microseconds a small ball.
std::vector<double> ballMeans(const Image& image, const std::vector<Sphere<3>>& spheres);

}  // namespace vdbpack
