// Names of files in the values of options, which recipes give by their own folder.
#pragma once

#include "vdbpack/options/option.h"

#include <string>

namespace vdbpack {

/// The value of an option in a recipe as the command line would have it: names of files that are
/// relative to the recipe's folder as the working folder sees them. Shapes, numbers and words stay.
/// @param in      where the value names a file.
/// @param folder  of the recipe; empty: the working folder.
/// @throws ParameterError for the prefix of a format without a file
std::string fromRecipe(FileIn in, const std::string& value, const std::string& folder);

/// The reverse: the value as a recipe in `folder` has it. Absolute names stay; so do, as absolute
/// names, those with nothing but the root in common with the folder.
std::string forRecipe(FileIn in, const std::string& value, const std::string& folder);

}  // namespace vdbpack
