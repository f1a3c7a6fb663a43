// Private to image: volumes of DICOM slices.
#pragma once

#include "vdbpack/image/dicom_slices.h"
#include "vdbpack/image/image_file.h"

#include <string>
#include <vector>

namespace vdbpack {

/// A file of several frames, or a folder of the files of one series. Slices are placed by their
/// positions, in whatever order they are stored. @throws as `readImage`
Image readDicom(const std::string& path, const ImageReadOptions& options);

/// @throws InputError for a slice of another size, direction, spacing or stack than the first
void requireAlike(const DicomSlice& slice, const DicomSlice& first);

/// The grid of slices, which it sorts. @param isSpaced  set to whether they state all distances
/// @throws InputError unless they are alike and evenly spaced
ImageGrid gridOfSlices(std::vector<DicomSlice>& slices, const ImageReadOptions& options,
                       const std::string& path, bool& isSpaced);

/// The pixels of all frames of a file, as stored. @param any  of its slices. @throws InputError
std::vector<char> pixelsOf(const DicomSlice& any);

}  // namespace vdbpack
