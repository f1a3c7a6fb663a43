// What picture a run is asked for.
#pragma once

#include "vdbpack/preview/preview.h"

#include <string>

namespace vdbpack {

/// A picture of what a run makes, and how its report page shows it.
struct PreviewRecipe {
    std::string file;  ///< .png; empty: none
    std::optional<PreviewCut> cut;
    PreviewColor color = PreviewColor::radius;
    int width = 1600, height = 1200;  ///< pixels
};

}  // namespace vdbpack
