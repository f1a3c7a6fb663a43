// Private: MetaImage files (.mha, .mhd).
#pragma once

#include "vdbpack/image/image_file.h"

#include <string>

namespace vdbpack {

/// Voxels in the file itself or in one other, raw or deflated.
/// @throws as `readImage`
Image readMetaImage(const std::string& path, const ImageReadOptions& options);

}  // namespace vdbpack
