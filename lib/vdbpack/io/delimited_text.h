// Private: text files of rows whose cells are separated by commas, semicolons, tabs or blanks.
#pragma once

#include "vdbpack/io/input_file.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

using Cells = std::vector<std::string_view>;

/// A .csv or .tsv file, or a table separated by blanks, read row by row.
///
/// A cell may be in double quotes (RFC 4180, but without line ends inside). Blank lines and
/// comments (#) are skipped. Without `readHeader` each row has the separator that suits it and any
/// number of cells.
class DelimitedText {
public:
    /// @throws IoError
    explicit DelimitedText(const std::string& path);

    const InputFile& file() const { return file_; }
    InputFile& file() { return file_; }

    /// Reads the names of the columns: the first line that is no comment or, if only that one has a
    /// name for the x coordinate, the last such comment above it. All rows then have the header's
    /// separator and number of cells.
    /// @param columns  names to write, and `alternative` another remedy ("or ..."), for messages.
    /// @throws InputError if no line names columns.
    void readHeader(const std::string& columns, const std::string& alternative = {});
    /// The same where the caller names the columns: takes the first line only if it has no number.
    /// @throws InputError if it has not one cell for each name.
    void takeNames(std::vector<std::string> names);
    const std::vector<std::string>& names() const { return names_; }
    std::uint64_t headerLine() const { return headerLine_; }

    /// The first column has texts, which may begin with #: a comment with as many cells as a row
    /// is refused from here on.
    void refuseAmbiguousComments() { refuseAmbiguousComments_ = true; }

    /// Cuts the next row into `cells`, valid until the next call. @return false after the last.
    /// @throws InputError naming the line if it has more or fewer cells than there are columns, or
    /// an open quote.
    bool nextRow(Cells& cells);

private:
    /// @return false if a quote is left open.
    bool split(std::string_view line, char separator, Cells& cells);
    void setHeader(const std::string& line, std::uint64_t number);
    bool namesCoordinates(std::string_view line);

    InputFile file_;
    char separator_ = ',';  ///< ' ' for any number of blanks and tabs
    std::uint64_t headerLine_ = 0;
    std::vector<std::string> names_;
    bool refuseAmbiguousComments_ = false;
    std::string storage_;  ///< of quoted cells
};

/// A column's name without case, signs and what follows a bracket: "thetaz" for "Theta_Z [rad]".
std::string canonicalName(std::string_view name);

/// What the name of a column says: "posx" and "um" for "Pos_X [um]", "Pos_X/um" and "pos_x_um";
/// "points0" and "" for "Points[0]" and "Points_0".
struct ColumnName {
    std::string quantity;  ///< as `canonicalName`
    std::string unit;      ///< any word in brackets or behind a slash, or one of length
};
ColumnName columnName(std::string_view name);

/// The quantities that are a coordinate, 0 to 2, the best first: x, posx, xpos, positionx, ...
std::vector<std::string> axisNames(int axis);

}  // namespace vdbpack
