// The shell that a recipe of voids asks for.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/voids/void_recipe.h"

#include <utility>

namespace vdbpack {

/// The smallest and the largest thickness of the shell, mm, before there is a domain. Reads the
/// file of `shellField`. @throws as `readScalarField`; InputError for a negative thickness
std::pair<double, double> shellRange(const VoidRecipe& recipe);

/// The shell of a domain: `shell`, or by place as `shellField` says.
/// @param bounds       of the domain, mm. @param sliceHeight  2D: height of the plane, mm.
/// @throws as `shellRange`; InputError for a field that does not cover `bounds`
template <int Dim>
ShellThickness shellOver(const VoidRecipe& recipe, const Box<Dim>& bounds, double sliceHeight);

}  // namespace vdbpack
