// Private to previews: the scale bar of a picture.
#pragma once

#include "vdbpack/preview/picture.h"

#include <string>

namespace vdbpack {

/// Length of a scale bar and its parts.
struct ScaleBar {
    double length = 0;  ///< mm; 0: none
    int parts = 0;

    std::string words() const;  ///< "20 mm"; empty: there is none
};
/// The bar that takes a tenth to a quarter of a picture's width.
/// @param mmPerPixel  the scale that the bar shows.
ScaleBar scaleBarFor(double mmPerPixel, int width);
/// Draws the bar between two rows of pixels from the left end at column `left`.
/// @param pixels  its length.
void drawScaleBar(const ScaleBar& bar, double pixels, int left, int top, int bottom,
                  Picture& image);

}  // namespace vdbpack
