#include "vdbpack/preview/color.h"

#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

// Ends of the ramp in Oklab: lightness, hue in degrees; and its chroma.
constexpr double kDark = 0.40, kLight = 0.93;
constexpr double kBlue = 278, kYellow = 103;
constexpr double kChroma = 0.16;
constexpr int kSteps = 256;

float decoded(double s) {
    return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

Color fromOklab(double lightness, double a, double b) {
    const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
    const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
    const double s = std::pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
    return {static_cast<float>(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            static_cast<float>(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            static_cast<float>(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

bool shown(const Color& c) {
    return std::min({c.r, c.g, c.b}) >= 0 && std::max({c.r, c.g, c.b}) <= 1;
}

Color rampAt(double t) {
    const double lightness = kDark + (kLight - kDark) * t;
    const double hue = (kBlue + (kYellow - kBlue) * t) * kPi / 180;
    Color c;
    for (double chroma = kChroma;; chroma *= 0.98) {
        c = fromOklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
        if (shown(c)) return c;
    }
}

}  // namespace

Color fromSrgb(std::uint32_t rgb) {
    return {decoded((rgb >> 16 & 255) / 255.0), decoded((rgb >> 8 & 255) / 255.0),
            decoded((rgb & 255) / 255.0)};
}

void toSrgb(const Color& color, std::uint8_t* rgb) {
    const auto encode = [](float v) {
        const float c = std::min(std::max(v, 0.0f), 1.0f);
        const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
        return static_cast<std::uint8_t>(s * 255 + 0.5f);
    };
    rgb[0] = encode(color.r);
    rgb[1] = encode(color.g);
    rgb[2] = encode(color.b);
}

Color rampColor(double t) {
    static const auto table = [] {
        std::array<Color, kSteps> colors;
        for (int i = 0; i < kSteps; ++i)
            colors[static_cast<std::size_t>(i)] = rampAt(static_cast<double>(i) / (kSteps - 1));
        return colors;
    }();
    const double at = t > 0 ? std::min(t, 1.0) : 0;  // NaN: the low end
    return table[static_cast<std::size_t>(at * (kSteps - 1) + 0.5)];
}

}  // namespace vdbpack
