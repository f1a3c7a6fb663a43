// Pictures and PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// A picture in 8 bits of sRGB.
struct Picture {
    int width = 0, height = 0;         ///< pixels
    std::vector<std::uint8_t> pixels;  ///< red, green, blue; row by row from the top left
    /// Keywords (Latin-1, 1 to 79 characters) and UTF-8 texts that are written into the file.
    std::vector<std::pair<std::string, std::string>> texts;

    const std::uint8_t* pixel(int x, int y) const {
        return &pixels[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(x))];
    }
    std::uint8_t* pixel(int x, int y) {
        return const_cast<std::uint8_t*>(static_cast<const Picture*>(this)->pixel(x, y));
    }
};

/// The bytes of a PNG file with the texts; the same picture gives the same bytes.
/// @throws ParameterError if `pixels` does not have three values per pixel.
std::string encodePng(const Picture& image);

/// Writes a PNG file, whole or not at all. @throws ParameterError, IoError
void writePng(const Picture& image, const std::string& path);

}  // namespace vdbpack
