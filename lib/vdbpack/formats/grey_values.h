// Grey values of images as properties of spheres.
#pragma once

#include "vdbpack/core/pack.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdbpack {

struct Callbacks;
struct DomainRecipe;

/// Properties of spheres from the grey values of images.
struct GreyRecipe {
    /// "NAME=IMAGE": columns of the mean of an image over each sphere (`ballMeans`).
    std::vector<std::string> samples;
    /// "SLOPE,INTERCEPT": density of each sphere, kg/m³, from the only sample; with "NAME=" before
    /// it, from a column of that name. Empty: none.
    std::string calibration;
    /// "A,B": Young's modulus A * density^B, MPa, of a density in g/cm³; "E": without densities.
    /// Empty: none.
    std::string modulus;
    /// Samples are means over balls of at least this diameter, mm: about a sphere that is smaller.
    double sampleLength = 0;
    int classes = 10;  ///< of density, for programs that know materials by number

    bool empty() const { return samples.empty() && calibration.empty() && modulus.empty(); }
};

/// Refuses, before the work, samples that are malformed, have the name of another column, or name
/// no image, and what is malformed or lacks its column otherwise.
/// @param density  that is set beside, as `particleDensity` takes it; empty: none.
/// @param columns  of numbers that spheres have before; null: unknown.
/// @return the images. @throws ParameterError, IoError
std::vector<std::string> checkGrey(const GreyRecipe& recipe, const std::string& density,
                                   const std::vector<std::string>* columns = nullptr);
/// The names of the columns of numbers of a pack.
std::vector<std::string> columnsOfNumbers(const PackAttributes& pack);

/// What parts of a pack have of their own, whatever grey values say.
struct PartProperties {
    std::map<std::int32_t, double> density;       ///< kg/m³, by `Materials::withoutClass`
    std::map<std::int32_t, std::string> modulus;  ///< by part, as `GreyRecipe::modulus`
};

/// Whether a modulus, as `GreyRecipe` has it, follows from densities. @throws ParameterError
bool needsDensity(const std::string& modulus);

/// Adds to a pack a column for each sample, an image in the world that `domain` says, and those of
/// density, its classes and moduli (`kDensityColumn`, ...) where they are requested.
/// @throws InputError, IoError, ResourceError, ParameterError for a column that is not there
template <int Dim>
void addGreyValues(const GreyRecipe& recipe, const DomainRecipe& domain,
                   const PartProperties& parts, Pack<Dim>& pack, const Callbacks& callbacks);

/// Adds requested densities, kg/m³, as column `kDensityColumn`: files of the pack then hold them.
/// @param all, ofMaterials  as `SphereDensities`; without them, nothing is done
void keepDensities(PackAttributes& pack, std::size_t spheres, double all,
                   const std::map<std::int32_t, double>& ofMaterials);

}  // namespace vdbpack
