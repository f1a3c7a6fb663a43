// A solid as a dense box of voxels: what is measured voxel by voxel.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

class VdbGrid;

/// Signed distances at the centers of cubic voxels. A voxel is solid if its distance is < 0.
struct VoxelImage {
    std::array<std::int64_t, 3> size{};  ///< voxels along x, y, z
    double voxelSize = 0;                ///< mm
    Vec<3> origin;                       ///< center of voxel (0, 0, 0), mm
    /// mm, x fastest, then y, then z; negative in the solid. May be clamped some three voxels from
    /// the surface: only the values next to it are used.
    std::vector<float> distance;
    /// One a voxel, in the same order, or empty. 0: no part of the total volume; else the region
    /// of the total volume that the voxel belongs to. Empty: the box is the total volume.
    std::vector<std::uint8_t> label;
    /// mm, in the same order: how deep each voxel lies below the wall of the total volume, negative
    /// beyond it; may be clamped as `distance` is. Or empty: the total volume was cut from a larger
    /// sample. With it, the solid and the pore space end at the wall.
    std::vector<float> depth;

    bool inTotal(std::size_t voxel) const { return label.empty() || label[voxel] != 0; }
    std::size_t voxels() const {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
               static_cast<std::size_t>(size[2]);
    }
};

/// The most voxels an image may have; 1290 along each side take 9 GB, with morphometry 54.
inline constexpr std::uint64_t kLargestImage = std::uint64_t{1} << 31;

/// An image whose distances are still to be set.
/// @param first      center of the first voxel of the total volume, mm.
/// @param count      voxels of the total volume along x, y, z.
/// @param rim        further voxels on all sides; those get the label 0, the others 1.
/// @throws ResourceError above `kLargestImage` voxels or if memory does not suffice.
VoxelImage emptyImage(const Vec<3>& first, const std::array<double, 3>& count, double voxelSize,
                      double rim);

/// A level set as voxels.
///
/// @param grid       from `MeshDomain::grid` or read from a file; mm.
/// @param bounds     part to sample, mm; a solid that it cuts continues beyond it. Absent: the
///                   bounding box of the voxels inside, with a margin of at least one voxel, so
///                   that the image shows where the solid ends.
/// @param voxelSize  mm; 0: the grid's own voxels without interpolation, those whose centers lie
///                   in `bounds`. Else voxels fill `bounds` from its low corner (the last ones may
///                   protrude) and take the trilinear value. Voxels wider than half of the grid's
///                   band lose the place of the surface between them.
/// @param margin     mm; voxels this far beyond `bounds` are added with label 0 (all others are
///                   then labeled 1): balls and distances at the rim of the total volume then know
///                   the surface beyond it.
/// @throws ParameterError for an unusable size, margin or empty bounds; InputError if nothing is
/// inside, or if the grid's own voxels are requested and do not lie along x, y, z; ResourceError
/// above `kLargestImage` voxels or if memory does not suffice.
///
/// Cost: about 10 ns a voxel on two threads, 50 if interpolated.
VoxelImage sampleLevelSet(const VdbGrid& grid, const std::optional<Box<3>>& bounds = {},
                          double voxelSize = 0, double margin = 0);

}  // namespace vdbpack
