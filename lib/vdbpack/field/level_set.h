// Level sets: where they come from and what can be asked of them, without OpenVDB's headers.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/units.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace vdbpack {

class VdbGrid;

/// Reads a level set from a .vdb file, in mm.
/// @param gridName  may be empty: the first level set of the file.
/// @param scale     a factor on all lengths.
/// @param unit      of the lengths in the file, unless the grid states its own, as ours do.
/// @throws IoError if the file cannot be read, InputError if it contains no such level set, or one
/// whose voxels are not cubes, ParameterError if `scale` is not positive, ResourceError.
std::shared_ptr<const VdbGrid> levelSetGrid(const std::string& path, const std::string& gridName,
                                            double scale, Unit unit = Unit::millimeter);

/// A grid of floats that is no level set, such as a fog volume.
struct FogVolume {
    std::string grid;  ///< its name
    double lowest = 0, highest = 0;
};

/// The fog volume of that name in a .vdb file; for an empty name the first one, if `besides` level
/// sets or there are none. Nothing if there is none.
/// @throws IoError, InputError if the file cannot be read.
std::optional<FogVolume> findFogVolume(const std::string& path, const std::string& gridName,
                                       bool besides);

/// The surface where a fog volume has the value `threshold`, mm; outward triangles, the inside
/// having larger values. @throws as `levelSetGrid`; InputError if `threshold` is not between the
/// values outside and inside.
TriangleMesh fogVolumeMesh(const std::string& path, const std::string& gridName, double scale,
                           double threshold, Unit unit = Unit::millimeter);

/// Whether a .vdb file contains a level set; false as well where it cannot be read.
bool holdsLevelSet(const std::string& path);

/// The zero contour of a level set, outward triangles, mm.
/// @param name  of the level set in messages.
/// @param adaptivity  0 to 1: how much triangles may join where the surface is nearly flat.
/// @throws InputError if there is no contour, or one that is not finite.
TriangleMesh levelSetMesh(const VdbGrid& grid, const std::string& name, double adaptivity = 0);

/// The same of a level set in a file. @throws as `levelSetGrid` besides.
TriangleMesh levelSetMesh(const std::string& path, const std::string& gridName, double scale);

/// The name of a level set's grid.
std::string levelSetName(const VdbGrid& grid);
/// The same level set under another name; they share their voxels.
std::shared_ptr<const VdbGrid> renamed(const VdbGrid& grid, const std::string& name);
/// Edge of a voxel, mm.
double voxelSizeOf(const VdbGrid& grid);
/// Center of the voxel (0, 0, 0), mm.
Vec<3> originOf(const VdbGrid& grid);
/// Voxels in the band.
std::uint64_t activeVoxels(const VdbGrid& grid);
/// The box around the band, mm.
Box<3> bandBounds(const VdbGrid& grid);
/// Whether the indices of the voxels count along x, y and z.
bool liesAlongAxes(const VdbGrid& grid);

/// A copy with the band cut to `width` on both sides, mm; the band must be that wide.
std::shared_ptr<const VdbGrid> narrowed(const VdbGrid& grid, double width);

/// Center of the voxel (0, 0, 0) of a level set made for `bounds`, mm: the middle of the bounds
/// plus arbitrary fractions of a voxel, so that planes of labels or of round numbers lie between
/// centers of voxels.
template <int Dim>
Vec<Dim> fieldOrigin(const Box<Dim>& bounds, double voxelSize) {
    constexpr std::array<double, 3> kOff{0.123, 0.234, 0.345};
    Vec<Dim> origin = bounds.center();
    for (int d = 0; d < Dim; ++d) origin[d] += kOff[static_cast<std::size_t>(d)] * voxelSize;
    return origin;
}

}  // namespace vdbpack
