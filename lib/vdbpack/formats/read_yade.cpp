// YADE's text formats (ymport.text, textExt and textClumps): x y z r and what the #format line
// adds; files of SpherePack.save have a fifth column at most, the clump.
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::string_view kFormat = "#format";

/// The columns of a format such as id_x_y_z_r_matId. @return false if it is not known.
bool columnsOf(std::string_view format, std::vector<std::string>& names, bool& attributes) {
    std::string_view rest = Words(format).next();
    names.clear();
    constexpr std::string_view kId = "id_";
    if (startsWith(rest, kId)) {
        names.push_back("id");
        rest.remove_prefix(kId.size());
    }
    constexpr std::string_view kSphere = "x_y_z_r";
    if (!startsWith(rest, kSphere)) return false;
    rest.remove_prefix(kSphere.size());
    names.insert(names.end(), {"x", "y", "z", "r"});
    attributes = rest == "_attrs";
    if (rest == "_matId") names.push_back("region");
    if (rest == "_clumpId") names.push_back(kYadeClump);
    return rest.empty() || attributes || rest == "_matId" || rest == "_clumpId";
}

/// Adds the names of the attributes: those that export.textExt writes as "# x y z r name ...", or
/// else attribute1, attribute2, ...
void nameAttributes(std::string_view firstRow, std::string_view comment,
                    std::vector<std::string>& names) {
    Cells cells, words;
    splitAtBlanks(firstRow, cells);
    splitAtBlanks(comment, words);
    const std::size_t known = names.size();
    const bool named = words.size() == cells.size() && words.size() > known &&
                       std::equal(names.begin(), names.end(), words.begin());
    for (std::size_t c = known; c < cells.size(); ++c)
        names.push_back(named ? std::string(words[c]) : fmt::format("attribute{}", c - known + 1));
}

/// Drops a column of clumps without one: -1 of all spheres.
void dropNoClumps(std::vector<Column>& columns) {
    const auto isNone = [](const Column& c) {
        return c.name == kYadeClump && !c.numbers.empty() &&
               std::all_of(c.numbers.begin(), c.numbers.end(),
                           [](double clump) { return clump == -1; });
    };
    columns.erase(std::remove_if(columns.begin(), columns.end(), isNone), columns.end());
}

}  // namespace

Pack<3> readYade(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    TextTable table;
    table.options = options;
    table.names = {"x", "y", "z", "r"};
    bool attributes = false;  // there may be any number of further columns
    bool hasFormat = false;
    std::string comment;  // the last one above the spheres
    std::string cell, periods;
    const std::string kCellNote = std::string(kCellKey) + ": ";
    std::string_view line;

    // The header: comments up to the first sphere.
    std::uint64_t begin = 0;
    std::uint64_t lineBefore = 0;
    for (;; begin = file.offset(), lineBefore = file.lineNumber()) {
        if (!file.nextLine(line)) return {};
        line = trimmed(line);
        if (line.empty()) continue;
        if (line.front() != '#') break;
        if (startsWith(line, kFormat)) {
            const auto format = trimmed(line.substr(kFormat.size()));
            hasFormat = true;
            if (!columnsOf(format, table.names, attributes))
                file.failAtLine("format " + quotedExcerpt(format) +
                                " is not supported; use x_y_z_r, which id_ may precede and _matId, "
                                "_clumpId or _attrs follow");
        } else if (line.find(kCellNote) != std::string_view::npos) {
            cell = line.substr(line.find(kCellNote) + kCellNote.size());
        } else if (startsWith(line, kYadeCell)) {
            periods = line.substr(kYadeCell.size());
        } else {
            table.options.unit = unitIn(line, table.options.unit, file);
            comment = line.substr(1);
        }
    }
    if (attributes) nameAttributes(line, comment, table.names);
    Cells firstRow;
    splitAtBlanks(line, firstRow);
    if (!hasFormat && firstRow.size() == 5) table.names.push_back(kYadeClump);

    file.seek(begin, lineBefore);
    table.nextRow = [&](Cells& cells) {
        do {
            if (!file.nextLine(line)) return false;
            line = trimmed(line);
            if (startsWith(line, kFormat))
                file.failAtLine("the format line must come before the spheres; move it");
        } while (line.empty() || line.front() == '#');
        splitAtBlanks(line, cells);
        requireWords(file, table.names, cells);
        return true;
    };
    Pack<3> pack = readTable(file, table);
    dropNoClumps(pack.columns);
    // The periods have no corner: positions are those of any image.
    if (cell.empty() && !periods.empty()) cell = "xyz 0 0 0 " + periods;
    if (!cell.empty()) pack.cell = cellIn(cell, table.options.unit, path);
    return pack;
}

}  // namespace vdbpack
