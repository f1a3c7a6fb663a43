// Checks of a recipe of voids against its files and its domain, before the work.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/voids/void_recipe.h"

namespace vdbpack {

/// Refuses, before the work, fields of voids whose files are of no known type or are not there.
/// @throws ParameterError, IoError
void requireVoidFields(const VoidRecipe& voids);

/// Refuses a shell that is as thick as the domain before a field is made for it.
/// @param closer  makes a coarse field to find out, in less than a second; else the box around the
///                domain says it.
/// @throws InputError
void requireShell(double shell, const DomainSource& source, bool closer = false);

/// Refuses voids that a periodic cell cannot have, and a shell, since there is no wall around it.
/// @throws ParameterError
void requireRepeating(const DomainSource& source, const VoidRecipe& voids);

}  // namespace vdbpack
