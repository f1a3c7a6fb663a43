// The recipe that a run leaves beside what it wrote, so that it can be repeated.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/report/report.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The recipe with its seed, and above it, as comments, how to use it and what it gave.
/// @param toml  options under [command]; {seed} stands for that of the report.
/// @param file  what it is written as.
std::string recipeFileText(const std::string& toml, const std::string& file, const Report& report);

/// The hash that a file which `leaveRecipe` wrote states; nothing if there is none.
std::optional<std::uint64_t> statedHash(const std::string& file);

/// Whether the recipe in a file ends with the text of its parts file, as comments.
bool holdsPartsText(const std::string& recipe);

/// Writes the recipe beside the first output, as NAME.recipe.toml, or, where that is the recipe of
/// other outputs, with their extension too, as NAME.EXT.recipe.toml. Adds it to `report.files` and
/// keeps it in `report.recipe`. A file of that name that is no such recipe stays, with a warning,
/// and names that are not UTF-8 are in no recipe, with another. Nothing is done where there are no
/// outputs or no options.
/// @throws IoError
void leaveRecipe(const std::string& toml, const std::vector<OutputTarget>& outputs, Report& report,
                 const Callbacks& callbacks);

}  // namespace vdbpack
