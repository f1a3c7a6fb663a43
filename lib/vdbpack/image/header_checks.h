// Private: what libraries do not check in the headers of images before they trust them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace vdbpack {

/// Whether the name ends in .tif or .tiff.
bool isTiff(const std::string& path);

/// How the first page of a TIFF file stores its pixels.
struct TiffPixels {
    std::uint64_t bits = 1, samples = 1;  ///< bits of each sample, samples of a pixel
    std::uint64_t color = 1;              ///< 0: grey, 0 is white; 1: grey, 0 is black; else colors
    std::uint64_t number = 1;             ///< 1: unsigned
    bool tiled = false;

    bool isGrey() const { return samples == 1 && color <= 1; }
};

/// Refuses TIFF files whose pages run in a circle, or lie outside of the file, and grey ones of
/// numbers that ITK does not read. @throws InputError, IoError
TiffPixels checkTiffPages(const std::string& path);

/// Refuses NIfTI files, also gzipped ones, whose header is no such or has impossible sizes.
/// @return whether its pixdim states the distance of voxels along each axis; niftilib takes 1 where
/// it does not. @throws InputError, IoError
std::array<bool, 3> checkNiftiHeader(const std::string& path);

}  // namespace vdbpack
