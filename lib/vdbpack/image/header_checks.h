// Private: what libraries do not check in the headers of images before they trust them.
#pragma once

#include <array>
#include <string>

namespace vdbpack {

/// Whether the name ends in .tif or .tiff.
bool isTiff(const std::string& path);

/// Refuses TIFF files whose pages run in a circle, or lie outside of the file.
/// @throws InputError, IoError
void checkTiffPages(const std::string& path);

/// Refuses NIfTI files, also gzipped ones, whose header is no such or has impossible sizes.
/// @return whether its pixdim states the distance of voxels along each axis; niftilib takes 1 where
/// it does not. @throws InputError, IoError
std::array<bool, 3> checkNiftiHeader(const std::string& path);

}  // namespace vdbpack
