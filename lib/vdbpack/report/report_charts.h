// The charts of a report.
#pragma once

#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/report/report.h"

#include <optional>
#include <string>

namespace vdbpack {

/// Figures as `figure` makes them: sizes by number and cumulated, contacts, solid fraction by
/// depth, pair correlation, time by stage. A chart without data states the reason.
std::string reportCharts(const Report& report, const std::optional<Structure>& structure,
                         const RadiusHistogram& radii);

}  // namespace vdbpack
