// Where the voxels of an image lie in the world.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace vdbpack {

/// Voxels in rows along three axes, which need not be perpendicular to the axes of the world.
/// The world is that of DICOM and ITK, mm: x grows to the patient's left, y to the back
/// (posterior), z to the head (superior); "LPS".
struct ImageGrid {
    std::array<std::size_t, 3> size{};  ///< voxels along each axis; the first is stored fastest
    Vec<3> origin;                      ///< center of voxel (0, 0, 0)
    /// From each voxel to the next one along each axis.
    std::array<Vec<3>, 3> step{{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}};

    std::size_t voxels() const { return size[0] * size[1] * size[2]; }
    /// The point at an index; indices of voxel centers are whole numbers from 0.
    Vec<3> at(const Vec<3>& index) const {
        return origin + index[0] * step[0] + index[1] * step[1] + index[2] * step[2];
    }
    /// The index of a point.
    Vec<3> indexOf(const Vec<3>& point) const;
    /// Lengths of the steps.
    Vec<3> spacing() const { return {{length(step[0]), length(step[1]), length(step[2])}}; }
    /// Volume of a voxel, mm³; negative for left-handed axes.
    double signedVoxelVolume() const { return dot(step[0], cross(step[1], step[2])); }
    /// How far a ball of radius 1 reaches along each index.
    Vec<3> reach() const;
    /// Around all voxels, to their corners.
    Box<3> bounds() const;
    /// The anatomical directions that the axes are nearest to, such as "RAS": the index along the
    /// first axis grows to the right, along the second one to the front (anterior), along the third
    /// one to the head (superior).
    std::string orientation() const;
};

/// The grid with its steps along the axes of the world, for one that lies askew.
ImageGrid alongAxes(ImageGrid grid);

/// `ImageGrid::indexOf` of many points.
class ImageIndexer {
public:
    explicit ImageIndexer(const ImageGrid& grid);
    Vec<3> indexOf(const Vec<3>& point) const {
        const Vec<3> from = point - origin_;
        return {{dot(from, across_[0]) / volume_, dot(from, across_[1]) / volume_,
                 dot(from, across_[2]) / volume_}};
    }

private:
    Vec<3> origin_;
    std::array<Vec<3>, 3> across_;  ///< perpendicular to the two other steps
    double volume_;
};

}  // namespace vdbpack
