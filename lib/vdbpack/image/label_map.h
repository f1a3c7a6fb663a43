// Spheres and solids as label maps.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/image/image_grid.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdbpack {

/// A whole number at each voxel of a grid; 0 for none.
struct LabelMap {
    ImageGrid grid;
    std::vector<std::int32_t> labels;  ///< x fastest, then y, then z
};

/// The same space in voxels of other sizes: axes and corner are kept, and the last voxels may reach
/// beyond. @param spacing  mm, along each axis.
ImageGrid withSpacing(const ImageGrid& grid, const Vec<3>& spacing);

/// Voxels along x, y, z that fill a box from its low corner (the last ones may reach beyond), with
/// one more voxel on each side.
ImageGrid gridAround(const Box<3>& box, const Vec<3>& spacing);

/// The label of a sphere at each voxel whose center lies in it; where several do, of the last.
/// @param labels  one a sphere.
/// Cost: about 2 ns a voxel in the box around a sphere, on two threads. @throws ResourceError
LabelMap labelMapOf(const std::vector<Sphere<3>>& spheres, const std::vector<std::int32_t>& labels,
                    const ImageGrid& grid);

/// The label that a function gives to each center of a voxel.
/// @param sampler  makes a function for one thread. @throws ResourceError
LabelMap labelMapOf(const std::function<std::function<std::int32_t(const Vec<3>&)>()>& sampler,
                    const ImageGrid& grid);

/// Whether a label map can have this name: .nii .nii.gz .nrrd .mha.
bool namesLabelMap(const std::string& path);

/// Writes a label map as the smallest of uint8, uint16 and int32 that holds it, compressed but in
/// .nii. Axes as in the grid, LPS; .nii (an sform of 32-bit numbers) in RAS. Whole or absent.
/// @param note  of the program, where the format has a place for it.
/// @throws ParameterError (another extension; more than 32,767 voxels along an axis in .nii),
/// IoError, ResourceError
void writeLabelMap(const LabelMap& map, const std::string& path, const std::string& note);

}  // namespace vdbpack
