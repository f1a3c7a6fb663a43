#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>

namespace vdbpack {

namespace {

constexpr std::string_view kSeparators = " \t,;";
constexpr std::size_t kShown = 20;  // characters of a line in a message

/// Appends the cells of a line to `cells`.
/// @return how many.
std::size_t readRow(const InputFile& file, std::string_view line,
                    std::vector<std::uint8_t>& cells) {
    const std::size_t before = cells.size();
    for (std::size_t at = 0; at < line.size(); ++at) {
        const char c = line[at];
        if (kSeparators.find(c) != std::string_view::npos) continue;
        if (c != '0' && c != '1')
            throw InputError(fmt::format(
                "{}: line {}: '{}' is neither 0 nor 1; write 1 for a void, 0 for none", file.path(),
                file.lineNumber(),
                line.substr(at, std::min(line.find_first_of(kSeparators, at) - at, kShown))));
        cells.push_back(c == '1' ? 1 : 0);
    }
    if (cells.size() == before)
        throw InputError(fmt::format(
            "{}: line {}: '{}' has no 0 or 1; write the cells of the row or remove the line",
            file.path(), file.lineNumber(), line.substr(0, kShown)));
    return cells.size() - before;
}

}  // namespace

VoidMatrix readVoidMatrix(const std::string& path) {
    InputFile file(path);
    std::vector<std::uint8_t> paper;  // in the order of the file: top row first
    std::size_t columns = 0, rows = 0, row = 0, layers = 0;
    std::uint64_t firstLine = 0, lastLine = 0;
    const auto endLayer = [&] {
        if (row == 0) return;
        if (layers++ == 0) rows = row;
        if (row != rows)
            throw InputError(
                fmt::format("{}: line {}: layer {} has {} rows, but the first layer has {}; give "
                            "all layers as many rows, with a blank line between layers",
                            path, lastLine, layers, row, rows));
        row = 0;
    };
    std::string_view line;
    while (file.nextLine(line)) {
        if (file.lineNumber() == 1 && line.substr(0, 3) == "\xef\xbb\xbf") line.remove_prefix(3);
        const bool blank = trimmed(line).empty();
        line = trimmed(line.substr(0, line.find('#')));
        if (blank) endLayer();
        if (line.empty()) continue;
        const std::size_t count = readRow(file, line, paper);
        if (columns == 0) {
            columns = count;
            firstLine = file.lineNumber();
        }
        if (count != columns)
            throw InputError(
                fmt::format("{}: line {}: row has {} cells, but line {} has {}; complete the row",
                            path, file.lineNumber(), count, firstLine, columns));
        ++row;
        lastLine = file.lineNumber();
    }
    endLayer();
    if (paper.empty())
        throw InputError(path + ": is empty; write rows of 0 and 1, the top row first");
    constexpr std::size_t kLimit = std::numeric_limits<int>::max();
    if (std::max({columns, rows, layers}) > kLimit)
        throw InputError(fmt::format("{}: {} x {} x {} cells are too many; split the matrix", path,
                                     columns, rows, layers));

    VoidMatrix matrix;
    matrix.size = {static_cast<int>(columns), static_cast<int>(rows), static_cast<int>(layers)};
    matrix.cells.reserve(paper.size());
    for (std::size_t k = 0; k < layers; ++k)
        for (std::size_t j = rows; j-- > 0;) {
            const auto begin =
                paper.begin() + static_cast<std::ptrdiff_t>((k * rows + j) * columns);
            matrix.cells.insert(matrix.cells.end(), begin,
                                begin + static_cast<std::ptrdiff_t>(columns));
        }
    return matrix;
}

}  // namespace vdbpack
