// What runs with several seeds have in common: a table, and its summary.
#pragma once

#include "vdbpack/report/report.h"

#include <string>
#include <vector>

namespace vdbpack {

/// CSV: a line of names, then a line a report; cells without a value are empty.
std::string studyTable(const std::vector<Report>& reports);

/// For people: a line a run, then mean and standard deviation over runs that differ in their seeds.
/// @param interrupted  whether further runs are missing.
std::string studySummary(const std::vector<Report>& reports, bool interrupted);

}  // namespace vdbpack
