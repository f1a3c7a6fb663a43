// Private to image: segmentations of DICOM as label maps.
#pragma once

#include "vdbpack/image/dicom_slices.h"
#include "vdbpack/image/image_file.h"

#include <string>
#include <vector>

namespace vdbpack {

/// The segments of a file as labels with their numbers and names; segments that overlap lie in
/// layers of their own. Slices without a frame are empty. A fraction of at least a half counts as
/// inside.
/// @param frames  of the file. @throws as `readImage`
Image readSegments(const std::string& path, const std::vector<DicomSlice>& frames,
                   const ImageReadOptions& options);

}  // namespace vdbpack
