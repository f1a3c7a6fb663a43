// Settings that all commands share.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/core/units.h"
#include "vdbpack/preview/preview_recipe.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Properties of spheres from the grey values of images.
struct GreyRecipe {
    /// "NAME=IMAGE": columns of the mean of an image over each sphere (`ballMeans`).
    std::vector<std::string> samples;
    /// "SLOPE,INTERCEPT": density of each sphere, kg/m³, from the only sample; with "NAME=" before
    /// it, from a column of that name. Empty: none.
    std::string calibration;
    /// "A,B": Young's modulus A * density^B, MPa, of a density in g/cm³. Empty: none.
    std::string modulus;
    int classes = 10;  ///< of density, for programs that know materials by number

    bool empty() const { return samples.empty() && calibration.empty() && modulus.empty(); }
};

/// Base of all recipes. A command passes over what it has no use for.
struct RunSettings {
    int threads = 0;         ///< of each rank; 0: all cores
    Ranks* ranks = nullptr;  ///< with which `pack` is run; null: there are none
    double memoryLimit = 0;  ///< bytes that the process may hold; 0: what is free at the start
    std::uint64_t seed = 1;  ///< of all random numbers
    double contactTolerance = 1e-3;    ///< gap up to which spheres touch, in smaller radii
    std::vector<std::string> outputs;  ///< files, as `writeOutput` names them
    Unit outUnit = Unit::millimeter;   ///< of the lengths in them
    bool images = false;  ///< files for viewers hold the images in a periodic cell, too
    std::string density;  ///< of the spheres in DEM files, as `particleDensity` takes it
    GreyRecipe grey;
    PreviewRecipe preview;   ///< picture; without a file: none
    std::string reportFile;  ///< .json or .html; empty: none
    std::string command;     ///< for the report; empty: the task and what it works on
    /// TOML with the options that repeat the run ({seed} for the seed): written beside the first
    /// output as NAME.recipe.toml. Empty: none is written.
    std::string optionsText;
};

}  // namespace vdbpack
