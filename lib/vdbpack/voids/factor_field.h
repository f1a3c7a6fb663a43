// Factors on the radii of spheres by place.
#pragma once

#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/pack/size_field.h"
#include "vdbpack/voids/scalar_field.h"

#include <memory>
#include <string>

namespace vdbpack {

/// Refuses, before the work, a file that is no field by its name or is not there; an empty name
/// passes. @throws ParameterError, IoError
void checkFactorField(const std::string& file);

/// The factors of a field or a grey image; null for an empty name.
/// @param domain  whose world an image lies in.
/// @throws as `readScalarField` and `readImage`; InputError for factors that are not positive, or
/// span a ratio above 20
std::shared_ptr<const ScalarField> readFactors(const std::string& file, const DomainRecipe& domain);

/// The factors as a lattice over a domain.
/// @param file         that they were read from. @param bounds  of the domain, mm.
/// @param sliceHeight  2D: height of the plane, mm.
/// @throws InputError for a field that does not cover the domain
template <int Dim>
std::shared_ptr<const SizeField> factorsOver(const std::shared_ptr<const ScalarField>& factors,
                                             const std::string& file, const Box<Dim>& bounds,
                                             double sliceHeight);

}  // namespace vdbpack
