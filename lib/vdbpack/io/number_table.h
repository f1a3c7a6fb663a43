// Private: tables of numbers in text files, columns by name.
#pragma once

#include "vdbpack/io/delimited_text.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// A delimited text file whose header names the columns and whose rows have numbers. Names count
/// as `canonicalName` returns them.
class NumberTable {
public:
    /// @param expected  the columns to write, for messages.
    /// @throws IoError, InputError if no line names columns.
    NumberTable(const std::string& path, const std::string& expected);

    /// The column that goes by one of `names`, if there is one.
    /// @throws InputError if there are two.
    std::optional<std::size_t> find(const std::vector<std::string>& names) const;
    /// The same where it is required. @throws InputError naming the first of `names`.
    std::size_t require(const std::vector<std::string>& names) const;

    /// Moves on to the next row. @return false after the last.
    /// @throws InputError if it has more or fewer cells than there are columns.
    bool nextRow() { return text_.nextRow(cells_); }
    /// Whether the row has something in this column.
    bool filled(std::size_t column) const { return !cells_[column].empty(); }
    /// The number there. @throws InputError naming line and column if it is none or not finite.
    double number(std::size_t column) const;

    /// @throws InputError about the row.
    [[noreturn]] void failRow(const std::string& what) const { text_.file().failAtLine(what); }
    /// @throws InputError about the columns; the message lists them.
    [[noreturn]] void failColumns(const std::string& what) const;

private:
    DelimitedText text_;
    std::string expected_;
    std::vector<std::string> canonical_;  ///< names of the columns
    Cells cells_;
};

}  // namespace vdbpack
