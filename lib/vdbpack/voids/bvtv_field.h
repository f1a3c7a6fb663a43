// BV/TV by place, from images and tables.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/voids/void_recipe.h"

#include <functional>

namespace vdbpack {

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
