// Patterns of cells that contain a void or none.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Cells of a box that contain a void (1) or none (0).
struct VoidMatrix {
    std::array<int, 3> size{};        ///< cells along x, y and z; a single layer applies to all z
    std::vector<std::uint8_t> cells;  ///< 0 or 1; x fastest, then y, then z, each upward

    /// Whether cell `i` along +x, `j` along +y, `k` along +z contains a void; each in [0, size).
    bool at(int i, int j, int k) const {
        const auto row = static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
                         static_cast<std::size_t>(j);
        return cells[row * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(i)] != 0;
    }
};

/// Reads a matrix of 0 and 1 as printed on paper: columns along x, the first row at the top
/// (largest y). Digits may be separated by blanks, tabs, commas or semicolons, or by nothing; #
/// begins a comment. Blank lines separate layers, the first layer at the lowest z.
///
/// @throws InputError with the line if there are other characters, no cells, rows of different
///         lengths or layers with different numbers of rows
/// @throws IoError
VoidMatrix readVoidMatrix(const std::string& file);

}  // namespace vdbpack
