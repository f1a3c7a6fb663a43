// Private: tables of numbers in text files, columns by name.
#pragma once

#include "vdbpack/io/input_file.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// A text file whose first line names the columns and whose further lines are rows of numbers,
/// separated by commas, semicolons, tabs or blanks.
///
/// Blank lines and comments (#) are passed over; the names may stand behind a # themselves.
/// Names count without case, signs and what follows a bracket: "Theta_Z [rad]" is "thetaz".
class NumberTable {
public:
    /// @param expected  the columns to write, for messages.
    /// @throws IoError, InputError if no line names columns.
    NumberTable(const std::string& path, const std::string& expected);

    /// The column that goes by one of `names`, if there is one.
    /// @throws InputError if there are two.
    std::optional<std::size_t> find(const std::vector<std::string>& names) const;
    /// The same where it has to be there. @throws InputError naming the first of `names`.
    std::size_t require(const std::vector<std::string>& names) const;

    /// Moves on to the next row. @return false after the last.
    /// @throws InputError if it has more or fewer cells than there are columns.
    bool nextRow();
    /// Whether the row has something in this column.
    bool filled(std::size_t column) const { return !cells_[column].empty(); }
    /// The number there. @throws InputError naming line and column if it is none or not finite.
    double number(std::size_t column) const;

    /// @throws InputError about the row.
    [[noreturn]] void failRow(const std::string& what) const;
    /// @throws InputError about the columns; the message lists them.
    [[noreturn]] void failColumns(const std::string& what) const;

private:
    bool takeHeader(std::string_view line);

    InputFile file_;
    std::string expected_;
    char separator_ = ',';
    std::uint64_t headerLine_ = 0;
    std::vector<std::string> names_;      ///< as written
    std::vector<std::string> canonical_;  ///< as they count
    std::vector<std::string_view> cells_;
};

}  // namespace vdbpack
