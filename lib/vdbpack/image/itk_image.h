// Private to image: what ITK reads.
#pragma once

#include "vdbpack/image/image_file.h"

#include <string>
#include <vector>

namespace vdbpack {

/// .nrrd, .nhdr, or one .tif of several pages. @throws as `readImage`
Image readByItk(const std::string& path, const ImageReadOptions& options);

/// Files of one slice each, in order. @throws as `readImage`
Image readTiffStack(const std::vector<std::string>& files, const ImageReadOptions& options);

}  // namespace vdbpack
