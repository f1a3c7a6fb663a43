// Reading label maps and CT from the files of scanners and segmentation tools.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/image/image.h"

#include <optional>
#include <string>

namespace vdbpack {

/// Whether a path is read as an image: .nii .nii.gz .nrrd .nhdr .mha .mhd .dcm, a folder of DICOM
/// or TIFF files or of masks, .tif .tiff, or a pattern of such ("slices/*.tif").
bool namesImage(const std::string& path);

struct ImageReadOptions {
    /// Distances of voxels along the axes, mm, where files state none that is a positive number:
    /// TIFF, some others. Distances that are stated are kept.
    std::optional<Vec<3>> spacing;
    Callbacks callbacks{};  ///< warnings, where a file says less than it should
};

/// Reads an image into the world of DICOM, mm.
///
/// Pixels of NIfTI, MetaImage and the geometry of NRRD are read here, the others by niftilib, GDCM
/// and ITK. A unit that a file states is used, with a warning where it is not mm. Of NIfTI the
/// sform is used, else the qform. Direction cosines that are perpendicular up to 1e-3 are made so
/// (with a warning above 1e-5); axes that are sheared by more are kept as they are, with a warning.
/// Slices and frames of DICOM are placed by their positions, which must be evenly spaced. TIFF
/// stacks are sorted by the numbers in their names, which must follow in even steps. Segments of
/// DICOM segmentations are labels with names, those that overlap in layers of their own; so are
/// the masks of a folder of .nii .nii.gz .nrrd .nhdr .mha .mhd, by the names of their files.
///
/// @throws InputError for content that is no image or cannot be placed, IoError if a file cannot be
/// read, ParameterError for a useless `spacing` or where the build has no image libraries,
/// ResourceError if memory does not suffice.
Image readImage(const std::string& path, const ImageReadOptions& options = {});

}  // namespace vdbpack
