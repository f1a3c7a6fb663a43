// Private to runs: how large files will be.
#pragma once

#include <string>

namespace vdbpack {

struct Extent;

/// Estimated size of an output (`writeOutput`), bytes.
double outputBytes(const std::string& output, const Extent& extent);

/// Voxels of the field's band inside and outside of the wall.
double bandVoxels(const Extent& extent);

/// Faces of voxels in the walls of voids, where they are not inside of other voids.
double voidFaces(const Extent& extent);

}  // namespace vdbpack
