// Private to previews: colors in linear light.
#pragma once

#include <array>
#include <cstdint>

namespace vdbpack {

/// Red, green, blue of sRGB's primaries in linear light, 0 to 1.
struct Color {
    float r = 0, g = 0, b = 0;

    Color& operator+=(const Color& o) {
        r += o.r, g += o.g, b += o.b;
        return *this;
    }
    friend Color operator+(Color sum, const Color& o) { return sum += o; }
    friend Color operator*(const Color& c, float s) { return {c.r * s, c.g * s, c.b * s}; }
    friend Color operator*(const Color& c, const Color& o) {
        return {c.r * o.r, c.g * o.g, c.b * o.b};
    }
};

/// Linear interpolation from `a` (t = 0) to `b` (t = 1).
inline Color between(const Color& a, const Color& b, float t) {
    return a * (1 - t) + b * t;
}

/// From 0xRRGGBB in sRGB.
Color fromSrgb(std::uint32_t rgb);
/// To 8 bits of sRGB; clamped to white.
void toSrgb(const Color& color, std::uint8_t* rgb);

/// A ramp from dark blue (0) through green to light yellow (1) with linear lightness, so that equal
/// steps look equal, also in gray print; values are clamped to [0, 1].
///
/// Lightness and hue of Oklab are linear (Ottosson 2020, "A perceptual color space for image
/// processing", public domain); chroma is reduced where sRGB is exceeded.
Color rampColor(double t);

}  // namespace vdbpack
