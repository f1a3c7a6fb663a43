// Reports as files: .json for programs, .html for people.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/run/run.h"

#include <string>

namespace vdbpack {

/// Where the report of a run is written: `settings.reportFile`, or its `interruptedName`; empty if
/// it is.
std::string reportFileOf(const RunSettings& settings, const Report& report);

/// Writes `settings.reportFile`, if it is set, in the format of its extension. @throws IoError
/// @param subject  what the run worked on.
void writeReport(const RunResult& run, const std::string& subject, const RunSettings& settings,
                 const PageDetails& details = {});
void writeReport(const MeasureResult& result, const MeasureRecipe& recipe);

/// The result of a run on a pack that exists, with its report written.
RunResult reported(RunResult run, const InputPack& recipe);

}  // namespace vdbpack
