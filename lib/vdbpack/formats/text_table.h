// Private: the rows of a text file as a pack.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/io/delimited_text.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdbpack {

struct TextTable {
    std::vector<std::string> names;  ///< of the columns, as `PackBuilder` takes them
    Unit unit = Unit::millimeter;    ///< of lengths in the file
    std::uint64_t expectedRows =
        0;  ///< as the file announces; memory is reserved for those that fit into it
    /// Reads row `row` into `cells`, one per column; returns false after the last row. Called from
    /// row 0 again if the table is read a second time.
    std::function<bool(std::uint64_t row, Cells& cells)> nextRow;
    /// Changes the row just added, where the pack holds other values than the cells; may be empty.
    std::function<void(PackBuilder& builder, const Cells& cells)> adjustRow;
};

/// Reads the rows from the file's next line on. Further columns are numbers if all of their cells
/// are, else texts as in the file.
/// @throws InputError naming line and column, IoError
Pack<3> readTable(InputFile& file, const TextTable& table);

}  // namespace vdbpack
