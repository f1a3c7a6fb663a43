// Private to runs: the structure of a real specimen as targets.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/voids/void_recipe.h"

namespace vdbpack {

/// The recipe with the structure of the specimen that a foam shall be like as its targets
/// (`aimAt`).
///
/// A specimen is an image (with a threshold of grey values), a level set or a mesh. Its total
/// volume is the image, or the domain of the request, or else the bounding box of the solid, taken
/// as cut from a larger specimen.
/// @param domain  of the run: an image that states no distances of voxels takes its distances.
/// @throws as `runMeasure`; InputError for a sample without solid or without pores
VoidRecipe withSample(VoidRecipe recipe, const DomainRecipe& domain, const Callbacks& callbacks);

}  // namespace vdbpack
