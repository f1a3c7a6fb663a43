// Solves for the amount of voids at which BV/TV reaches its target.
#pragma once

#include "vdbpack/voids/void_recipe.h"

#include <functional>
#include <string>

namespace vdbpack {

/// Finds the amount in [lo, hi] at which BV/TV, which decreases with the amount, is the target: by
/// false position on the logarithm of BV/TV, which is nearly linear, within the bracket so far.
/// @param r          has a target BV/TV.
/// @param guess      the first amount tried.
/// @param tolerance  of BV/TV; after 20 tries the best amount is taken.
/// @param remedy     end of the message if the target is not reachable.
/// @param bvtvAt     BV/TV at an amount; the last call is for the amount that is returned.
/// @param steepness  about how fast ln BV/TV falls with the amount; 0: as exp(-amount) does.
/// @throws ParameterError if BV/TV at `hi` is above the target or at `lo` below it.
double solveForBvtv(const VoidRecipe& r, double lo, double guess, double hi, double tolerance,
                    const std::string& remedy, const std::function<double(double)>& bvtvAt,
                    double steepness = 0);

}  // namespace vdbpack
