// How much of a kind of voids makes a wanted BV/TV.
#pragma once

#include "vdbpack/voids/void_recipe.h"

#include <functional>
#include <string>

namespace vdbpack {

/// Finds the amount in [lo, hi] at which BV/TV, which falls with it, is the target: along the line
/// through the two nearest results (its logarithm is nearly straight), between what was too little
/// and too much.
/// @param r          has a target.
/// @param tolerance  how near BV/TV has to come; after 16 tries the nearest is taken.
/// @param remedy     end of the message where the target cannot be reached.
/// @param bvtvAt     BV/TV of an amount; called last for the one that is returned.
/// @throws ParameterError if BV/TV at `hi` is above the target or at `lo` below it.
double solveForBvtv(const VoidRecipe& r, double lo, double guess, double hi, double tolerance,
                    const std::string& remedy, const std::function<double(double)>& bvtvAt);

}  // namespace vdbpack
