// The grips between which `stiffness` presses a body.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/report/run_result.h"

namespace vdbpack {

/// Two grips, and what they hold: as deep as asked, or else four mean radii, and deeper until what
/// both hold covers `kCovers` of the cross-section: an end may be hollow, such as a vertebra's.
/// @param volume  of the body, mm³. @throws ParameterError where nothing is left between them.
StiffnessResult::Pressed gripsOn(const StiffnessRecipe& recipe, const Pack<3>& pack, double volume,
                                 const Callbacks& callbacks);

}  // namespace vdbpack
