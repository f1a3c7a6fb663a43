// What runs with several seeds have in common: a table, and its summary.
#pragma once

#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/report/report.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// CSV: a line of names, then a line a report; cells without a value are empty.
/// @param solids  what was measured of the solids of these reports, where no target says it.
std::string studyTable(const std::vector<Report>& reports,
                       const std::vector<std::optional<SolidMeasures>>& solids = {});

/// For people: a line a run, then mean and standard deviation over the runs.
/// @param interrupted  whether further runs are missing.
std::string studySummary(const std::vector<Report>& reports, bool interrupted);

}  // namespace vdbpack
