// Private to image: volumes of DICOM slices.
#pragma once

#include "vdbpack/image/image_file.h"

#include <string>

namespace vdbpack {

/// A file of several frames, or a folder of the files of one series. Slices are placed by their
/// positions, in whatever order they are stored. @throws as `readImage`
Image readDicom(const std::string& path, const ImageReadOptions& options);

}  // namespace vdbpack
