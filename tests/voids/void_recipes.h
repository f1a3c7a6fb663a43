// Recipes of runs with voids, by method.
#pragma once

#include "cli/recipes.h"

#include "vdbpack/run/run.h"

#include <string>

namespace vdbpack::test {

template <int Dim>
PackRecipe packOf(const std::string& method) {
    PackRecipe recipe = Dim == 3 ? recipeFor("box:24,24,24", "uniform:0.5,1")
                                 : recipeFor("rect:100,100", "uniform:0.5,1");
    recipe.voids.method = method;
    return recipe;
}

/// Voids of the Boolean model in a box of side 10, for a BV/TV.
/// @param radius  SPEC of the shorter half-axis.
inline VoidsRecipe booleanRecipe(double bvtv, const std::string& radius,
                                 const std::string& output) {
    VoidsRecipe recipe;
    recipe.domain.source = "box:10,10,10";
    recipe.voids.method = "boolean";
    recipe.voids.radius = radius;
    recipe.voids.targetBvtv = bvtv;
    recipe.outputs = {output};
    return recipe;
}

/// A recipe of each method, as one would write it.
template <int Dim>
PackRecipe methodRecipe(const std::string& method) {
    PackRecipe recipe = packOf<Dim>(method);
    VoidRecipe& v = recipe.voids;
    if (method == "grid") {
        v.cell = "4";
        v.probability = 0.6;
    } else if (method == "overlay" || method == "boolean" || method == "foam") {
        v.radius = "uniform:1,2";
    } else if (method == "concentric" || method == "threshold") {
        v.deleteFraction = 0.3;
    } else {
        v.radius = "uniform:1.5,3";
        v.probability = 0.03;
    }
    return recipe;
}

}  // namespace vdbpack::test
