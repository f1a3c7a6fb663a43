// What reports and recipes say of values that a run finds for options that are given as words.
#pragma once

#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/report/report.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace vdbpack {

/// Adds the threshold of a domain that was read, unless it was given as a number.
void addThreshold(FoundValues& found, const DomainRecipe& domain);

/// [{"option": "threshold", "word": "otsu", "value": 302.5}]; several numbers are an array, and
/// "part" names one of several parts.
nlohmann::ordered_json toJson(const FoundValues& found);
/// For people: "threshold 302.5 (otsu)".
std::string textOf(const FoundValue& found);
/// The same as lines of a summary.
std::string foundRows(const FoundValues& found);
/// The options of a recipe as TOML, with the values in place of the words.
std::string withValues(std::string toml, const FoundValues& found);

}  // namespace vdbpack
