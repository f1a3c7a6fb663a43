// Reports as files: .json for programs, .html for people.
#pragma once

#include "vdbpack/report/page_details.h"
#include "vdbpack/run/run.h"

#include <string>

namespace vdbpack {

/// Where the report of a run is written: `settings.reportFile`, or its `interruptedName`; empty if
/// it is.
std::string reportFileOf(const RunSettings& settings, const Report& report);

/// Writes `recipe.reportFile`, if it is set, in the format of its extension. @throws IoError
void writeReport(const RunResult& run, const PageDetails& details, const PackRecipe& recipe);
void writeReport(const RunResult& run, const CarveRecipe& recipe);
void writeReport(const RunResult& run, const DensifyRecipe& recipe);
void writeReport(const RunResult& run, const VoidsRecipe& recipe);
void writeReport(const MeasureResult& result, const MeasureRecipe& recipe);

/// The same; returns the result.
template <class Recipe>
RunResult reported(RunResult result, const Recipe& recipe) {
    writeReport(result, recipe);
    return result;
}

}  // namespace vdbpack
