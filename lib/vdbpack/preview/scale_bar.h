// Private to previews: the scale bar of a picture.
#pragma once

#include "vdbpack/preview/picture.h"

namespace vdbpack {

/// Length of a scale bar and its parts.
struct ScaleBar {
    double length = 0;  ///< mm; 0: none
    int parts = 0;
};
/// The bar that takes a tenth to a quarter of a picture's width.
/// @param mmPerPixel  the scale that the bar shows.
ScaleBar scaleBarFor(double mmPerPixel, int width);
/// Draws the bar in the lower left corner, and its length beside it.
void drawScaleBar(const ScaleBar& bar, double mmPerPixel, Picture& image);

}  // namespace vdbpack
