#include "vdbpack/preview/scale_bar.h"

#include "vdbpack/preview/bitmap_text.h"
#include "vdbpack/preview/sphere_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

ScaleBar scaleBarFor(double mmPerPixel, int width) {
    const double limit = 0.25 * width * mmPerPixel;
    if (!(limit > 0) || !std::isfinite(limit)) return {};
    const double ten = std::pow(10, std::floor(std::log10(limit)));
    if (limit >= 5 * ten) return {5 * ten, 5};
    if (limit >= 2 * ten) return {2 * ten, 4};
    return {ten, 10};
}

void drawScaleBar(const ScaleBar& bar, double mmPerPixel, Picture& image) {
    if (!(bar.length > 0)) return;
    const double pixels = bar.length / mmPerPixel;
    const int thick = std::max(2, image.height / 150), margin = std::max(3, image.height / 40);
    const int y1 = image.height - margin, y0 = y1 - thick;
    std::uint8_t ink[3];
    toSrgb(inkColor(), ink);
    const auto paint = [&](int x, int y, float share, bool dark) {
        if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
        for (int c = 0; c < 3; ++c) {
            std::uint8_t& to = image.pixel(x, y)[c];
            const float color = dark ? ink[c] : 255;
            to = static_cast<std::uint8_t>(to + share * (color - to) + 0.5f);
        }
    };
    for (int x = margin; x < margin + pixels + 1; ++x) {
        // The end may lie within a pixel; the parts are dark and white in turn, with a dark frame.
        const double left = x - margin, inside = std::clamp(pixels - left, 0.0, 1.0);
        const auto part = static_cast<int>((left + 0.5) / pixels * bar.parts);
        const bool end = x == margin || left + 1 >= pixels;
        for (int y = y0; y < y1; ++y)
            paint(x, y, static_cast<float>(inside), end || y == y0 || y + 1 == y1 || part % 2 == 0);
    }
    constexpr int kDotsBetween = 4;
    const int dot = std::max(1, image.height / 250);
    drawText(fmt::format("{:g} mm", bar.length),
             margin + static_cast<int>(std::ceil(pixels)) + kDotsBetween * dot, y1, dot, ink,
             image);
}

}  // namespace vdbpack
