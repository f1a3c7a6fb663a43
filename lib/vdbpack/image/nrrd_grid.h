// Private to image: where the voxels of a NRRD lie, by its header alone.
#pragma once

#include "vdbpack/image/image_file.h"
#include "vdbpack/image/text_header.h"

#include <string>

namespace vdbpack {

/// The grid that a header states, in the world of DICOM and mm; its size is not set.
///
/// The spaces of patients are turned to LPS; others, and none, are taken as
/// LPS with a warning. `space units` and `units` are used. Without `space directions`, distances
/// are `spacings`, else the steps of `axis mins` and `axis maxs`, which are the borders of cells
/// unless `centers` says that they are centers; they also say where the first voxel lies. Source:
/// https://teem.sourceforge.net/nrrd/format.html A distance that is not stated is not a number.
/// @param dimensions  axes of space that the image has. @param unit  set to `Image::unit`
/// @throws InputError
ImageGrid nrrdGrid(const TextHeader& header, std::size_t dimensions, const std::string& path,
                   const Callbacks& callbacks, double& unit);

/// Whether a header says which sides of a patient its axes point to.
bool namesSides(const TextHeader& header);

}  // namespace vdbpack
