// YADE's text formats (ymport.text, textExt and textClumps): x y z r and what the #format line
// adds; files of SpherePack.save have a fifth column at most, the clump.
#include "vdbpack/formats/materials.h"
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

/// What the comments above the spheres say.
struct YadeHeader {
    std::vector<std::string> names{"x", "y", "z", "r"};  ///< of the columns
    bool attributes = false;                             ///< any number of further columns
    bool hasFormat = false;
    std::string comment;  ///< the last one
    std::string cell, periods;
    std::vector<std::string> partNames;
    MaterialNumbers materials;
    PackOrigin origin;
};

/// @param options  whose unit is set
void takeComment(std::string_view line, const InputFile& file, YadeHeader& header,
                 PackReadOptions& options) {
    static const std::string kCellNote = std::string(kCellKey) + ": ",
                             kGeneratorNote = "# " + std::string(kGeneratorKey) + ": ";
    if (startsWith(line, kFormat)) {
        const auto format = trimmed(line.substr(kFormat.size()));
        header.hasFormat = true;
        if (!columnsOf(format, header.names, header.attributes))
            file.failAtLine("format " + quotedExcerpt(format) +
                            " is not supported; use x_y_z_r, which id_ may precede and _matId, "
                            "_clumpId or _attrs follow");
    } else if (line.find(kCellNote) != std::string_view::npos) {
        header.cell = line.substr(line.find(kCellNote) + kCellNote.size());
    } else if (startsWith(line, kYadeCell)) {
        header.periods = line.substr(kYadeCell.size());
    } else if (startsWith(line, kYadeMaterials) && header.names.back() == "region") {
        header.materials = MaterialNumbers(line, kYadeMaterials);
        if (header.materials.formula == kPartColumn) header.names.back() = kPartColumn;
        if (header.materials.areCounted()) {
            header.names.back() = "matId";
            options.callbacks.warn(fmt::format(
                "{}: materials are the {}, from which parts and regions are not read back; read "
                "the pack's .vtp or .vdb",
                file.path(), header.materials.formula));
        }
    } else if (startsWith(line, kGeneratorNote)) {
        header.origin = originIn(line);
    } else if (!takePartComment(line, header.partNames)) {
        options.unit = unitIn(line, options.unit, file);
        header.comment = line.substr(1);
    }
}

}  // namespace

Pack<3> readYade(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    TextTable table;
    table.options = options;
    YadeHeader header;
    std::string_view line;
    // The comments up to the first sphere.
    std::uint64_t begin = 0;
    std::uint64_t lineBefore = 0;
    for (;; begin = file.offset(), lineBefore = file.lineNumber()) {
        if (!file.nextLine(line)) return {};
        line = trimmed(line);
        if (line.empty()) continue;
        if (line.front() != '#') break;
        takeComment(line, file, header, table.options);
    }
    table.names = header.names;
    if (header.attributes) nameAttributes(line, header.comment, table.names);
    Cells firstRow;
    splitAtBlanks(line, firstRow);
    if (!header.hasFormat && firstRow.size() == 5) table.names.push_back(kYadeClump);

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
    header.materials.split(pack);
    setPartNames(pack, std::move(header.partNames));
    pack.origin = header.origin;
    // The periods have no corner: positions are those of any image.
    if (header.cell.empty() && !header.periods.empty()) header.cell = "xyz 0 0 0 " + header.periods;
    if (!header.cell.empty()) pack.cell = cellIn(header.cell, table.options.unit, path);
    return pack;
}

}  // namespace vdbpack
