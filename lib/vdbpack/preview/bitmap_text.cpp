#include "vdbpack/preview/bitmap_text.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace vdbpack {

namespace {

/// Each row from the top, its five dots from the left as bits 4 to 0.
struct Letter {
    char name;
    std::array<std::uint8_t, kLetterHeight> rows;
};
constexpr Letter kLetters[] = {
    {'0', {0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00010, 0b00100, 0b01000, 0b11111}},
    {'3', {0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {'.', {0, 0, 0, 0, 0, 0b01100, 0b01100}},
    {'-', {0, 0, 0, 0b11111, 0, 0, 0}},
    {'+', {0, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0}},
    {'e', {0, 0, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110}},
    {'m', {0, 0, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101}},
};

void drawLetter(const Letter& letter, int left, int top, int dot, const std::uint8_t ink[3],
                Picture& image) {
    for (int y = 0; y < kLetterHeight * dot; ++y)
        for (int x = 0; x < kLetterWidth * dot; ++x) {
            const int row = letter.rows[static_cast<std::size_t>(y / dot)];
            if ((row >> (kLetterWidth - 1 - x / dot) & 1) == 0) continue;
            const int to = left + x, at = top + y;
            if (to >= 0 && at >= 0 && to < image.width && at < image.height)
                std::copy_n(ink, 3, image.pixel(to, at));
        }
}

}  // namespace

void drawText(std::string_view text, int x, int y, int dot, const std::uint8_t ink[3],
              Picture& image) {
    for (const char c : text) {
        const auto* const letter = std::find_if(std::begin(kLetters), std::end(kLetters),
                                                [c](const Letter& l) { return l.name == c; });
        if (letter != std::end(kLetters))
            drawLetter(*letter, x, y - kLetterHeight * dot, dot, ink, image);
        x += (kLetterWidth + 1) * dot;
    }
}

}  // namespace vdbpack
