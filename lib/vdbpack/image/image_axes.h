// Private to image: axes as files have them, checked.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/image_file.h"

#include <string>

namespace vdbpack {

/// The type of such a name, in small letters ("uint8"). @throws InputError for one that images do
/// not have here: another name, or integers of 64 bits.
NumberType voxelType(const std::string& name, const std::string& path);

/// Bytes of a file. @throws IoError
std::uint64_t sizeOf(const std::string& path);

/// Sets distances of voxels as `options` say where the file has none. @param known  whether it does
/// @throws InputError where neither has
void applySpacing(ImageGrid& grid, const ImageReadOptions& options, bool known,
                  const std::string& path);

/// Makes axes perpendicular that are so up to rounding, as `readImage` says, and warns of others.
/// @throws InputError for axes without length or in one plane.
void checkAxes(ImageGrid& grid, const std::string& path, const Callbacks& callbacks);

/// An image of such a grid, whose numbers are still to be set.
/// @param fileBytes  of what they are read from; more than a compressed file of that size can hold
///                   is refused. @throws InputError, ResourceError
Image allocatedImage(const std::string& path, const ImageGrid& grid, std::size_t layers,
                     NumberType type, std::uint64_t fileBytes);

}  // namespace vdbpack
