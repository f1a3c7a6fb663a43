// A report as one page for the browser: numbers, charts, tables, and how to repeat the run.
#pragma once

#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/report/report.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

struct ReportPage {
    std::string subject;  ///< what was packed or measured, as it was named
    Report report;
    std::optional<Structure> structure;
    RadiusHistogram radii;
    PagePicture picture;
    std::optional<Morphometry> morphometry;  ///< of a solid, instead of a pack
    /// Settings of the run, requested or by default: name and value, in the order of the table.
    std::vector<std::pair<std::string, std::string>> settings;
};

/// One HTML file, also well-formed XML, without external files, and without scripts but for that of
/// a view; light and dark, for phone, desktop and print. The same for the same input. Values of
/// curves and of numbers that may be absent are left out if they are not finite; all others are
/// finite.
/// @param figures  the JSON report, for the tables.
std::string reportPage(const ReportPage& page, const nlohmann::ordered_json& figures);

}  // namespace vdbpack
