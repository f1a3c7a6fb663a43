// Private to runs: grey values of images as properties of spheres.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/options/recipes.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdbpack {

/// Refuses, before the work, samples that are malformed, have the name of another column, or name
/// no image, and what is malformed or lacks its column otherwise.
/// @param columns  of numbers that spheres have before; null: unknown.
/// @return the images. @throws ParameterError, IoError
std::vector<std::string> checkGrey(const RunSettings& settings,
                                   const std::vector<std::string>* columns = nullptr);
/// The names of the columns of numbers of a pack.
std::vector<std::string> columnsOfNumbers(const PackAttributes& pack);

/// What parts of a pack have of their own, whatever grey values say.
struct PartProperties {
    std::map<std::int32_t, double> density;       ///< kg/m³, by `Materials::withoutClass`
    std::map<std::int32_t, std::string> modulus;  ///< by part, as `GreyRecipe::modulus`
};

/// Adds to a pack a column for each sample, an image in the world that `domain` says, and those of
/// density, its classes and moduli (`kDensityColumn`, ...) where they are requested.
/// @throws InputError, IoError, ResourceError, ParameterError for a column that is not there
template <int Dim>
void addGreyValues(const GreyRecipe& recipe, const DomainRecipe& domain,
                   const PartProperties& parts, Pack<Dim>& pack, const Callbacks& callbacks);

}  // namespace vdbpack
