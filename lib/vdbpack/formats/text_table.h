// Private: the rows of a text file as a pack.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/io/input_file.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

using Cells = std::vector<std::string_view>;

struct TextTable {
    std::vector<std::string> names;  ///< of the columns, as `PackBuilder` takes them
    Unit unit = Unit::millimeter;    ///< of lengths in the file
    std::uint64_t expectedRows =
        0;  ///< as the file claims; room is made for no more than fit in it
    /// Reads the row of this number into `cells`, one a column, or returns false after the last.
    /// Starts again at row 0 if the table is read a second time.
    std::function<bool(std::uint64_t row, Cells& cells)> nextRow;
    /// Changes the row just added, where cells are not what the pack holds; may be empty.
    std::function<void(PackBuilder& builder, const Cells& cells)> adjustRow;
};

/// Reads the rows from the file's next line on. Further columns are numbers if all of their cells
/// are, else texts as they stand in the file.
/// @throws InputError naming line and column, IoError
Pack<3> readTable(InputFile& file, const TextTable& table);

}  // namespace vdbpack
