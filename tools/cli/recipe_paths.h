// Names of files in the values of options, which recipes give by their own folder.
#pragma once

#include <string>

/// The value of an option in a recipe as the command line would have it: names of files that are
/// relative to the recipe's folder as the working folder sees them. Shapes, numbers and words stay.
/// @param option  long name, or that of the argument: DOMAIN, PACK, FILE.
/// @param folder  of the recipe; empty: the working folder.
std::string fromRecipe(const std::string& option, const std::string& value,
                       const std::string& folder);

/// The reverse: the value as a recipe in `folder` has it. Absolute names stay; so do, as absolute
/// ones, those that have nothing but the root in common with the folder.
std::string forRecipe(const std::string& option, const std::string& value,
                      const std::string& folder);
