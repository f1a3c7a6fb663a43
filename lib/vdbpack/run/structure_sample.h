// Private to runs: the structure of a real specimen as targets.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/voids/void_recipe.h"

namespace vdbpack {

/// The recipe with what it asks for indirectly: the numbers of a preset (`withPreset`), and where
/// `like` names a sample, its BV/TV, Tb.Th, Tb.Sp, DA, Conn.D, the distributions of thickness and
/// spacing, and its main direction, each unless the recipe has its own.
///
/// A sample is an image (with `likeThreshold` of grey values), a level set or a mesh. Its total
/// volume is the image, or `likeDomain`, or else the bounding box of the solid, taken as cut from a
/// larger specimen.
/// @throws as `runMeasure`; InputError for a sample without solid or without pores
VoidRecipe withSample(VoidRecipe recipe, const Callbacks& callbacks);

}  // namespace vdbpack
