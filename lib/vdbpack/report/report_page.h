// A report as one page for the browser: figures, charts, tables, and how to do it again.
#pragma once

#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/measure/structure.h"
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
    Structure structure;
    RadiusHistogram radii;
    std::string picture;                      ///< bytes of a PNG file; empty: none
    int pictureWidth = 0, pictureHeight = 0;  ///< pixels
    std::string pictureWords;                 ///< what it shows
    std::optional<Morphometry> morphometry;   ///< of a solid: then nothing of the above but the run
    /// What the run was told or chose, name and value, in the order of the table.
    std::vector<std::pair<std::string, std::string>> settings;
};

/// One file of HTML that is well-formed XML too: no scripts, nothing fetched, light and dark, for
/// phone, desk and paper. The same for the same input. Values of curves and of figures that may be
/// absent are left out where they are not finite; the others are.
/// @param figures  all that the JSON report holds, for the tables.
std::string reportPage(const ReportPage& page, const nlohmann::ordered_json& figures);

}  // namespace vdbpack
