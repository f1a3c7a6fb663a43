// BV/TV and factors on the radii of spheres by place, from images and tables.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/pack/size_field.h"
#include "vdbpack/voids/scalar_field.h"
#include "vdbpack/voids/void_recipe.h"

#include <functional>
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

/// BV/TV by place as a recipe of voids says; empty: the same everywhere.
/// @param domain  whose world an image lies in; in the plane at `sliceHeight`, mm.
/// @param bounds  of the domain. Warns where it reaches beyond an image.
/// @throws as `readImage` and `readScalarField`; InputError for an image of several layers or one
///         that lies elsewhere, and for another field that does not cover `bounds`
template <int Dim>
std::function<double(const Vec<Dim>&)> bvtvField(const VoidRecipe& voids,
                                                 const DomainRecipe& domain, const Box<Dim>& bounds,
                                                 double sliceHeight, const Callbacks& callbacks);

}  // namespace vdbpack
