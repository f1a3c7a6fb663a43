// Tables: one row a sphere, columns by name.
#include "vdbpack/core/error.h"
#include "vdbpack/export/input_file.h"
#include "vdbpack/export/numbers.h"
#include "vdbpack/export/pack_builder.h"
#include "vdbpack/export/pack_formats.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// A cell as RFC 4180 wants it: in quotes where it holds a comma, a quote or a line end.
void appendCell(std::string& text, const std::string& cell) {
    if (cell.find_first_of(",;\"\t\r\n") == std::string::npos) {
        text += cell;
        return;
    }
    text += '"';
    for (const char c : cell) {
        if (c == '"') text += '"';
        // Line ends inside a cell are legal but few readers survive them.
        text += c == '\n' || c == '\r' ? ' ' : c;
    }
    text += '"';
}

/// Splits a line into cells; quotes are resolved into `storage`.
/// @return false if a quote is left open.
bool splitLine(std::string_view line, char separator, std::vector<std::string_view>& cells,
               std::string& storage) {
    cells.clear();
    storage.clear();
    // Views into `storage` must survive its growth: it never grows beyond the line.
    storage.reserve(line.size());
    std::size_t at = 0;
    for (;;) {
        std::size_t begin = at;
        while (begin < line.size() && line[begin] == ' ') ++begin;
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
            at = std::min(line.find(separator, begin), line.size());
        } else {
            at = std::min(line.find(separator, at), line.size());
            cells.push_back(trimmed(line.substr(begin, at - std::min(begin, at))));
        }
        if (at >= line.size()) return true;
        ++at;
    }
}

char separatorOf(std::string_view header) {
    for (const char c : {',', ';', '\t'})
        if (header.find(c) != std::string_view::npos) return c;
    return ',';
}

}  // namespace

void writeCsv(const PackView& pack, OutputFile& out) {
    std::string header = "id,x,y,z,radius";
    if (!pack.region().empty()) header += ",region";
    if (!pack.order().empty()) header += ",order";
    if (pack.hasDepth()) header += ",depth";
    if (!pack.contacts().empty()) header += ",contacts";
    for (const auto& column : pack.columns()) {
        header += ',';
        appendCell(header, column.name);
    }
    header += '\n';
    out.write(header);

    writeRows(out, pack.size(), [&pack](std::string& text, std::size_t i) {
        appendNumber(text, pack.id(i));
        for (const double c : pack.position(i)) appendNumber(text += ',', c);
        appendNumber(text += ',', pack.radius(i));
        if (!pack.region().empty()) appendNumber(text += ',', std::int64_t{pack.region()[i]});
        if (!pack.order().empty()) appendNumber(text += ',', pack.order()[i]);
        if (pack.hasDepth()) appendNumber(text += ',', pack.depth(i));
        if (!pack.contacts().empty()) appendNumber(text += ',', std::int64_t{pack.contacts()[i]});
        for (const auto& column : pack.columns()) {
            text += ',';
            if (!column.texts.empty())
                appendCell(text, column.texts[i]);
            else if (!column.numbers.empty())
                appendNumber(text, column.numbers[i]);
        }
        text += '\n';
    });
}

Pack<3> readCsv(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    std::string_view line;
    bool found = false;
    while (!found && file.nextLine(line)) {
        if (file.lineNumber() == 1 && line.substr(0, 3) == "\xef\xbb\xbf") line.remove_prefix(3);
        found = !trimmed(line).empty();
    }
    if (!found) throw InputError(path + ": is empty; the first line must name the columns");
    if (line.front() == '#') line.remove_prefix(1);
    const char separator = separatorOf(line);

    std::vector<std::string_view> cells;
    std::string storage;
    if (!splitLine(trimmed(line), separator, cells, storage))
        throw InputError(
            fmt::format("{}: line {}: a quote is not closed; close it", path, file.lineNumber()));
    const std::vector<std::string> names(cells.begin(), cells.end());
    const std::uint64_t firstRow = file.nextOffset();
    const std::uint64_t firstRowNumber = file.lineNumber();

    // Further columns are numbers until a cell is none; then the file is read once more, since
    // numbers written anew would not be the texts that stood there.
    std::vector<bool> isText(names.size(), false);
    for (;;) {
        PackBuilder builder(path, names, options.unit);
        for (std::size_t c = 0; c < names.size(); ++c)
            if (isText[c]) builder.makeText(c);
        bool again = false;
        file.seek(firstRow, firstRowNumber);
        while (file.nextLine(line)) {
            if (trimmed(line).empty()) continue;
            const auto where = [&] { return fmt::format("line {}", file.lineNumber()); };
            if (!splitLine(line, separator, cells, storage))
                throw InputError(
                    fmt::format("{}: {}: a quote is not closed; close it", path, where()));
            if (cells.size() != names.size())
                throw InputError(fmt::format(
                    "{}: {}: has {} cells where the first line names {} columns; complete the "
                    "line or cut the file there",
                    path, where(), cells.size(), names.size()));
            builder.addRow();
            for (std::size_t c = 0; c < cells.size(); ++c) {
                if (builder.parse(c, cells[c])) continue;
                if (!builder.isFurther(c)) builder.failCell(where(), c, cells[c]);
                isText[c] = again = true;
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
        if (!again) return builder.finish();
    }
}

}  // namespace vdbpack
