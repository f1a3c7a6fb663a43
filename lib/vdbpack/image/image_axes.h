// Private to image: axes as files have them, checked.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/image_file.h"

#include <array>
#include <string>

namespace vdbpack {

/// The type of such a name, in small letters ("uint8"). @throws InputError for one that images do
/// not have here: another name, or integers of 64 bits.
NumberType voxelType(const std::string& name, const std::string& path);

/// Bytes of a file. @throws IoError
std::uint64_t sizeOf(const std::string& path);

/// Sets distances of voxels as `options` say where the file has none, or none that is a positive
/// number. @param known  whether it has, along each axis. @return whether it has along all axes
/// @throws InputError where neither has
bool applySpacing(ImageGrid& grid, const ImageReadOptions& options, std::array<bool, 3> known,
                  const std::string& path);

/// Millimeters per unit of a name that a file states; 0 for no name or an unknown one, with a
/// warning. Warns of factors other than 1.
double unitFactor(const std::string& unit, const std::string& path, const Callbacks& callbacks);

/// Makes axes perpendicular that are so up to rounding, as `readImage` says, and warns of others.
/// @throws InputError for axes without length or in one plane.
void checkAxes(ImageGrid& grid, const std::string& path, const Callbacks& callbacks);

/// The largest distance between the same corners of two grids of one size, in voxels of the first.
double cornersApart(const ImageGrid& a, const ImageGrid& b);

/// Numbers of a type as floats: slope * number + intercept. @param from  aligned for the type
void toFloats(NumberType type, const std::shared_ptr<std::byte[]>& from, std::size_t count,
              double slope, double intercept, float* to);

/// An image of such a grid, whose numbers are still to be set.
/// @param fileBytes  of what they are read from; more than a compressed file of that size can hold
///                   is refused. @throws InputError, ResourceError
Image allocatedImage(const std::string& path, const ImageGrid& grid, std::size_t layers,
                     NumberType type, std::uint64_t fileBytes);

}  // namespace vdbpack
