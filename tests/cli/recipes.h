// Recipes of runs for tests.
#pragma once

#include "vdbpack/run/recipe.h"

#include <string>

namespace vdbpack::test {

inline PackRecipe recipeFor(const std::string& domain, const std::string& radius) {
    PackRecipe recipe;
    recipe.domain.source = domain;
    recipe.radius = radius;
    return recipe;
}

}  // namespace vdbpack::test
