// Private to runs: how many voids a recipe will make, and how large.
#pragma once

#include "vdbpack/voids/void_recipe.h"

namespace vdbpack {

/// Voids to expect, before any is made. Lengths in mm.
struct PlannedVoids {
    double count = 0;      ///< 0: none
    double radius = 0;     ///< mean half-axis b
    double length = 0;     ///< mean half-axis a
    double voxelSize = 0;  ///< of their level sets
};

/// What is cut into, as far as voids depend on it.
struct VoidSurroundings {
    int dim = 3;
    double volume = 0, area = 0;  ///< of the domain, mm^dim and mm^(dim - 1)
    double spheres = 0;           ///< their number
    double largestRadius = 0;     ///< of the spheres, mm; 0: none
};

/// The voids that the recipe specifies, or that its target needs.
PlannedVoids planVoids(const VoidRecipe& recipe, const VoidSurroundings& around);

}  // namespace vdbpack
