// Recipes of runs with voids, by method.
#pragma once

#include "support/jobs.h"

#include "vdbpack/run/run.h"

#include <algorithm>
#include <array>
#include <string>
#include <variant>
#include <vector>

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
    auto recipe = voidsIn("box:10,10,10", output);
    setVoids(recipe.request, "boolean", radius, bvtv);
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

template <int Dim>
const Pack<Dim>& packIn(const RunResult& run) {
    return std::get<Pack<Dim>>(run.pack);
}

/// Positions and radii alone, to be found again.
template <int Dim>
std::vector<std::array<double, Dim + 1>> sorted(const std::vector<Sphere<Dim>>& spheres) {
    std::vector<std::array<double, Dim + 1>> all;
    for (const auto& s : spheres) {
        std::array<double, Dim + 1> one;
        for (std::size_t d = 0; d < Dim; ++d) one[d] = s.center.c[d];
        one[Dim] = s.radius;
        all.push_back(one);
    }
    std::sort(all.begin(), all.end());
    return all;
}

}  // namespace vdbpack::test
