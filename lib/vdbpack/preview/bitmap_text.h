// Private to previews: numbers and units in pictures.
#pragma once

#include "vdbpack/preview/picture.h"

#include <cstdint>
#include <string_view>

namespace vdbpack {

/// Rows of a letter, dots of the font's grid; the letters are five dots wide and one apart.
inline constexpr int kLetterHeight = 7, kLetterWidth = 5;

/// Draws digits, signs, dots, blanks and the letters e, m in a fixed font; others are left blank.
/// @param x, y  the left end of the letters' feet, pixels.
/// @param dot   pixels along a side of a dot.
void drawText(std::string_view text, int x, int y, int dot, const std::uint8_t ink[3],
              Picture& image);

}  // namespace vdbpack
