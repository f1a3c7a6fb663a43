// The picture of a run.
#pragma once

#include "vdbpack/preview/preview.h"

#include <string>

namespace vdbpack {

/// The picture of a run's result, also used by its report page.
struct PreviewRecipe {
    std::string file;  ///< .png; empty: none
    std::optional<PreviewCut> cut;
    PreviewColor color = PreviewColor::radius;
    std::string column;               ///< for PreviewColor::column
    int width = 1600, height = 1200;  ///< pixels
};

}  // namespace vdbpack
