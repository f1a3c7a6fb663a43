// Private: the rows of a text file as a pack.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/io/delimited_text.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct TextTable {
    std::vector<std::string> names;     ///< of the columns, as `PackBuilder` takes them
    PackReadOptions options;            ///< with the unit of lengths in the file
    std::optional<std::uint64_t> rows;  ///< as the file announces; null: up to its end
    /// Reads a row into `cells`; returns false after the last one. Called from the first row again
    /// if the table is read a second time.
    std::function<bool(Cells& cells)> nextRow;
    /// Changes the row just added, where the pack holds other values than the cells; may be empty.
    std::function<void(PackBuilder& builder, const Cells& cells)> adjustRow;
};

/// Reads the rows from the file's next line on. Further columns are numbers if all of their cells
/// are, else texts as in the file.
/// @throws InputError naming line and column, or how many rows are missing; IoError
Pack<3> readTable(InputFile& file, const TextTable& table);

/// Reads the words of the next line that is neither blank nor a comment (#).
/// @return false at the end of the file.
/// @throws InputError naming the line if there is not one word for each of `names`.
bool nextWords(InputFile& file, const std::vector<std::string>& names, Cells& words);
/// @param remedy  what to do otherwise, for the message.
void requireWords(const InputFile& file, const std::vector<std::string>& names, const Cells& words,
                  const char* remedy = "complete the line, or correct the header");

}  // namespace vdbpack
