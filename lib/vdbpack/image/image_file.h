// Reading label maps and CT from the files of scanners and segmentation tools.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/image/image.h"

#include <optional>
#include <string>

namespace vdbpack {

/// Whether a path is read as an image: .nii .nii.gz .nrrd .nhdr .mha .mhd .dcm, a folder of DICOM
/// or TIFF files, .tif .tiff, or a pattern of such ("slices/*.tif").
bool namesImage(const std::string& path);

struct ImageReadOptions {
    /// Distances of voxels along the axes, mm, of files that state none: TIFF, some NRRD and
    /// MetaImage. Others keep their own.
    std::optional<Vec<3>> spacing;
    Callbacks callbacks{};  ///< warnings, where a file says less than it should
};

/// Reads an image into the world of DICOM, mm.
///
/// NIfTI by niftilib, MetaImage here, the others by ITK. Of NIfTI the sform is used, else the
/// qform. Direction cosines that are perpendicular up to 1e-3 are made so (with a warning above
/// 1e-5); axes that are sheared by more are kept as they are, with a warning. Slices of a series
/// are placed by their positions, which must be evenly spaced. TIFF stacks are sorted by the
/// numbers in their names.
///
/// @throws InputError for content that is no image or cannot be placed, IoError if a file cannot be
/// read, ParameterError for a useless `spacing` or where the build has no image libraries,
/// ResourceError if memory does not suffice.
Image readImage(const std::string& path, const ImageReadOptions& options = {});

}  // namespace vdbpack
