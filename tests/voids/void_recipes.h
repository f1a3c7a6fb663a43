// Recipes of runs with voids, by method.
#pragma once

#include "cli/recipes.h"

#include "vdbpack/run/run.h"

#include <string>

namespace vdbpack::test {

template <int Dim>
PackJob packOf(const std::string& method) {
    PackJob recipe = Dim == 3 ? recipeFor("box:24,24,24", "uniform:0.5,1")
                              : recipeFor("rect:100,100", "uniform:0.5,1");
    recipe.request.method = method;
    return recipe;
}

/// Voids of the Boolean model in a box of side 10, for a BV/TV.
/// @param radius  SPEC of the shorter half-axis.
inline VoidsJob booleanRecipe(double bvtv, const std::string& radius, const std::string& output) {
    VoidsJob recipe;
    recipe.domain.source = "box:10,10,10";
    recipe.request.method = "boolean";
    recipe.request.radius = radius;
    recipe.request.targetBvtv = bvtv;
    recipe.outputs = {output};
    return recipe;
}

/// A recipe of each method, as one would write it.
template <int Dim>
PackJob methodRecipe(const std::string& method) {
    PackJob recipe = packOf<Dim>(method);
    VoidRequest& v = recipe.request;
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
