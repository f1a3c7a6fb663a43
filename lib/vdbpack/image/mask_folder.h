// Private to image: folders of masks, one file a label, as one label map.
#pragma once

#include "vdbpack/image/image_file.h"

#include <string>
#include <vector>

namespace vdbpack {

/// Whether a name is that of a file that can be a mask: .nii .nii.gz .nrrd .nhdr .mha .mhd.
bool namesMask(const std::string& path);

/// The masks of a folder as labels that have the names of the files without extension, and as
/// values their places among the files, from 1. Masks that are empty are left out, with a warning
/// that names them; masks that overlap others lie in layers of their own.
///
/// Memory: one mask at a time beside the label map.
/// @param files  of one folder, in order. @throws as `readImage`; InputError for a mask on another
/// grid, one of other values than 0 and one more, and where all are empty
Image readMasks(const std::vector<std::string>& files, const std::string& folder,
                const ImageReadOptions& options);

}  // namespace vdbpack
