// Private to runs: how many voids a recipe will make, and the memory of stamping them.
#pragma once

#include "vdbpack/voids/void_recipe.h"

namespace vdbpack {

struct Extent;

/// Voids as far as the memory of their level sets depends on them.
struct VoidExtent {
    double count = 0;      ///< 0: none
    double wall = 0;       ///< area (2D: length) of their walls outside of other voids, mm^(dim-1)
    double voxelSize = 0;  ///< mm
    double reach = 0;      ///< as that of StampOptions, mm
    double left = 1;       ///< share of the domain that lies outside of all voids
    double packed = 0;     ///< spheres of the pack that they are made from
    double specimenVoxels = 0;  ///< of the largest specimen measured to find them
};

/// The voids that the recipe specifies, or that its target needs.
/// @param extent         domain and number of spheres.
/// @param largestRadius  of the spheres, mm; 0: none.
VoidExtent planVoids(const VoidRecipe& recipe, const Extent& extent, double largestRadius);

/// Bytes at the peak of stamping the voids of an extent, with the level sets made of them.
double stampBytes(const Extent& extent);

}  // namespace vdbpack
