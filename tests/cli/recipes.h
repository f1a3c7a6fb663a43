// Recipes of runs for tests.
#pragma once

#include "vdbpack/run/recipe.h"

#include <string>

namespace vdbpack::test {

/// @param output  a file to write; empty: none.
inline PackRecipe recipeFor(const std::string& domain, const std::string& radius,
                            const std::string& output = {}) {
    PackRecipe recipe;
    recipe.domain.source = domain;
    recipe.radius = radius;
    if (!output.empty()) recipe.outputs = {output};
    return recipe;
}

}  // namespace vdbpack::test
