// Private to runs: sizes that are requested by place.
#pragma once

#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/voids/scalar_field.h"

#include <memory>

namespace vdbpack {

/// Refuses, before the work, a file that is no field by its name or is not there, and radii of a
/// shell without a shell. @throws ParameterError, IoError
void checkLocalSizes(const PackRecipe& recipe);

/// The factors on radii of `sizeField`; null: there are none.
/// @throws as `readScalarField` and `readImage`; InputError for factors that are not positive, or
/// span a ratio above 20
std::shared_ptr<const ScalarField> readFactors(const PackRecipe& recipe);

/// What differs by place in the sizes of a domain.
/// @param sliceHeight  2D: height of the plane, mm.
/// @throws InputError for a field that does not cover the domain
template <int Dim>
LocalSizes localSizes(const PackRecipe& recipe, const RequestedSizes& requested,
                      const Domain<Dim>& domain, double sliceHeight, const ShellThickness& shell);

}  // namespace vdbpack
