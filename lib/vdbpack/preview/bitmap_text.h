// Private to previews: words and numbers in pictures.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/preview/picture.h"

#include <algorithm>
#include <string_view>

namespace vdbpack {

/// Rows of a letter, dots of the font's grid; the letters are five dots wide and one apart.
inline constexpr int kLetterHeight = 7, kLetterWidth = 5;
/// Rows by which g, p, q and y reach below the feet of the other letters.
inline constexpr int kHang = 2;

/// Dots along a text.
inline int textDots(std::string_view text) {
    return std::max(0, (kLetterWidth + 1) * static_cast<int>(text.size()) - 1);
}

/// Draws letters and signs of ASCII in the color of outlines; a question mark for each byte of
/// others.
/// @param x, y  the left end of the letters' feet, pixels.
/// @param dot   pixels along a side of a dot.
void drawText(std::string_view text, int x, int y, int dot, Picture& image);

/// Draws a line with round ends on white; a disc where both ends are one point. All in pixels, y
/// down.
void drawStroke(const Vec<2>& from, const Vec<2>& to, double halfWidth, Picture& image);

}  // namespace vdbpack
