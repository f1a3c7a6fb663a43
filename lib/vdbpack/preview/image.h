// Pictures and PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// A picture in 8 bits of sRGB.
struct Image {
    int width = 0, height = 0;         ///< pixels
    std::vector<std::uint8_t> pixels;  ///< red, green, blue; row by row from the top left
    /// Keyword and text, written into the file: latin-1 keywords of 1 to 79 letters, UTF-8 texts.
    std::vector<std::pair<std::string, std::string>> texts;

    const std::uint8_t* pixel(int x, int y) const {
        return &pixels[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(x))];
    }
    std::uint8_t* pixel(int x, int y) {
        return const_cast<std::uint8_t*>(static_cast<const Image*>(this)->pixel(x, y));
    }
};

/// The bytes of a PNG file, with its texts. The same for the same picture.
/// @throws ParameterError if `pixels` does not have three values a pixel.
std::string encodePng(const Image& image);

/// Writes a PNG file, whole or not at all. @throws ParameterError, IoError
void writePng(const Image& image, const std::string& path);

}  // namespace vdbpack
