// Private to image: NIfTI-1 and NIfTI-2.
#pragma once

#include "vdbpack/image/image_file.h"

namespace vdbpack {

/// .nii, .nii.gz, or .hdr with .img. @throws as `readImage`
Image readNifti(const std::string& path, const ImageReadOptions& options);

}  // namespace vdbpack
