// Tables of any program: one row per sphere, columns by name.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// Splits a line into cells; quoted cells are unquoted into `storage`. With the separator ' ', any
/// number of blanks and tabs is one separator.
/// @return false if a quote is left open.
bool splitLine(std::string_view line, char separator, Cells& cells, std::string& storage) {
    cells.clear();
    storage.clear();
    // Views into `storage` must survive its growth: it never grows beyond the line.
    storage.reserve(line.size());
    const bool blanks = separator == ' ';
    const std::string_view separators = blanks ? " \t" : std::string_view(&separator, 1);
    if (blanks) line = trimmed(line);
    std::size_t at = 0;
    for (;;) {
        std::size_t begin = at;
        while (begin < line.size() && (line[begin] == ' ' || (blanks && line[begin] == '\t')))
            ++begin;
        if (begin < line.size() && line[begin] == '"') {
            const std::size_t start = storage.size();
            for (++begin;; ++begin) {
                if (begin >= line.size()) return false;
                if (line[begin] == '"' && (begin + 1 >= line.size() || line[begin + 1] != '"'))
                    break;
                if (line[begin] == '"') ++begin;
                storage += line[begin];
            }
            cells.push_back(std::string_view(storage).substr(start));
            at = std::min(line.find_first_of(separators, begin), line.size());
        } else {
            at = std::min(line.find_first_of(separators, blanks ? begin : at), line.size());
            cells.push_back(trimmed(line.substr(begin, at - std::min(begin, at))));
        }
        if (at >= line.size()) return true;
        ++at;
    }
}

/// The separator of the columns: the most frequent of comma, semicolon and tab, or
/// else blanks.
char separatorOf(std::string_view header) {
    header = trimmed(header);
    std::array<std::size_t, 3> counts{};
    constexpr std::string_view kSeparators = ",;\t";
    bool quoted = false;
    for (const char c : header) {
        quoted = quoted != (c == '"');
        const auto at = kSeparators.find(c);
        if (!quoted && at != std::string_view::npos) ++counts[at];
    }
    const auto most = std::max_element(counts.begin(), counts.end());
    return *most > 0 ? kSeparators[static_cast<std::size_t>(most - counts.begin())] : ' ';
}

/// Whether the line names columns: one of them is x.
bool namesColumns(std::string_view line) {
    Cells cells;
    std::string storage;
    if (!splitLine(line, separatorOf(line), cells, storage)) return false;
    return std::any_of(cells.begin(), cells.end(), [](std::string_view cell) {
        return cell == "x" || cell == "X" || cell == "Points:0" || cell == "Points_0";
    });
}

/// The line that names the columns.
struct Header {
    std::string text;
    std::uint64_t line = 0;  ///< its number
};

/// Finds the header and moves to the line after it: the first line of all, or else the last of the
/// comments above that line which names columns.
Header findHeader(InputFile& file) {
    Header comment;
    bool named = false;
    std::uint64_t begin = 0;
    std::uint64_t lineBefore = 0;
    std::string_view line;
    for (; file.nextLine(line); begin = file.nextOffset(), lineBefore = file.lineNumber()) {
        if (file.lineNumber() == 1 && line.substr(0, 3) == "\xef\xbb\xbf") line.remove_prefix(3);
        // Only for the test: tabs at the ends of the line separate empty cells, and stay.
        const auto content = trimmed(line);
        // Excel's line that names the separator; the header shows it as well.
        if (content.empty() || (content.substr(0, 4) == "sep=" && content.size() <= 5)) continue;
        if (content.front() != '#') {
            if (!named || namesColumns(line)) return {std::string(line), file.lineNumber()};
            file.seek(begin, lineBefore);
            return comment;
        }
        line.remove_prefix(line.find('#') + 1);
        if (named && !namesColumns(line)) continue;
        named = named || namesColumns(line);
        comment = {std::string(line), file.lineNumber()};
    }
    if (comment.line == 0)
        throw InputError(file.path() + ": is empty; the first line must name the columns");
    return comment;
}

}  // namespace

Pack<3> readCsv(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    const auto fail = [&path](std::uint64_t number, const std::string& what) {
        throw InputError(fmt::format("{}: line {}: {}", path, number, what));
    };
    const Header header = findHeader(file);
    const char separator = separatorOf(header.text);
    Cells names;
    std::string storage;
    if (!splitLine(header.text, separator, names, storage))
        fail(header.line, "a quote is not closed; close it");
    double number = 0;
    if (std::all_of(names.begin(), names.end(),
                    [&number](std::string_view name) { return parseNumber(name, number); }))
        fail(header.line,
             "holds numbers where the columns must be named; put a line x,y,z,radius above it, or "
             "read a list of x y z r as yade:FILE");

    TextTable table;
    table.names.assign(names.begin(), names.end());
    table.unit = options.unit;
    const bool startsWithText = PackBuilder(path, table.names, options.unit).isFurther(0);
    table.nextRow = [&](std::uint64_t, Cells& cells) {
        std::string_view line;
        while (file.nextLine(line)) {
            const auto content = trimmed(line);
            if (content.empty()) continue;
            const bool comment = content.front() == '#';
            if (comment && !startsWithText) continue;
            if (!splitLine(line, separator, cells, storage)) {
                if (comment) continue;
                fail(file.lineNumber(), "a quote is not closed; close it");
            }
            if (comment && cells.size() == table.names.size())
                fail(file.lineNumber(),
                     "may be a comment or a row; remove it, or put its first cell in quotes");
            if (comment) continue;
            if (cells.size() != table.names.size())
                fail(file.lineNumber(),
                     fmt::format("has {} cells where line {} names {} columns; complete the line "
                                 "or cut the file there",
                                 cells.size(), header.line, table.names.size()));
            return true;
        }
        return false;
    };
    return readTable(file, table);
}

}  // namespace vdbpack
