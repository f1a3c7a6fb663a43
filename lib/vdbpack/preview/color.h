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

/// `a` where t is 0, `b` where it is 1.
inline Color between(const Color& a, const Color& b, float t) {
    return a * (1 - t) + b * t;
}

/// From 0xRRGGBB as sRGB has it.
Color fromSrgb(std::uint32_t rgb);
/// To 8 bits of sRGB; what is brighter than white is white.
void toSrgb(const Color& color, std::uint8_t* rgb);

/// A ramp from dark blue (0) by green to light yellow (1) whose lightness rises evenly, so that
/// equal steps look equal, in gray print as well; values outside of [0, 1] are taken as its ends.
///
/// Straight in lightness and in hue of Oklab (Ottosson 2020, "A perceptual color space for image
/// processing", public domain); chroma gives way where sRGB ends.
Color rampColor(double t);

}  // namespace vdbpack
