#include "vdbpack/preview/scale_bar.h"

#include "vdbpack/preview/sphere_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

std::string ScaleBar::words() const {
    return length > 0 ? fmt::format("{:g} mm", length) : "";
}

ScaleBar scaleBarFor(double mmPerPixel, int width) {
    const double limit = 0.25 * width * mmPerPixel;
    if (!(limit > 0) || !std::isfinite(limit)) return {};
    const double ten = std::pow(10, std::floor(std::log10(limit)));
    if (limit >= 5 * ten) return {5 * ten, 5};
    if (limit >= 2 * ten) return {2 * ten, 4};
    return {ten, 10};
}

void drawScaleBar(const ScaleBar& bar, double pixels, int left, int top, int bottom,
                  Picture& image) {
    std::uint8_t ink[3];
    toSrgb(inkColor(), ink);
    for (int x = 0; x < pixels && left + x < image.width; ++x) {
        // The end may lie within a pixel; the parts are dark and white in turn, with a dark frame.
        const auto inside = static_cast<float>(std::min(pixels - x, 1.0));
        const auto part = static_cast<int>((x + 0.5) / pixels * bar.parts);
        const bool end = x == 0 || x + 1 >= pixels;
        for (int y = top; y < bottom; ++y)
            if (end || y == top || y + 1 == bottom || part % 2 == 0)
                for (int c = 0; c < 3; ++c)
                    image.pixel(left + x, y)[c] =
                        static_cast<std::uint8_t>(255 + inside * (ink[c] - 255.0f) + 0.5f);
    }
}

}  // namespace vdbpack
