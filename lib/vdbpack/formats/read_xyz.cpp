// Extended XYZ, as ASE and OVITO write it: frames of a count, a line that names the columns and a
// line per sphere.
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// The value of a key in the second line: in quotes, braces or plain. Empty if there is none.
/// @param key  in small letters.
std::string_view valueOf(std::string_view line, std::string_view key) {
    for (std::size_t at = 0; at < line.size();) {
        while (at < line.size() && (line[at] == ' ' || line[at] == '\t')) ++at;
        const std::size_t begin = at;
        while (at < line.size() && line[at] != ' ' && line[at] != '\t' && line[at] != '=') ++at;
        const auto word = line.substr(begin, at - begin);
        if (at >= line.size() || line[at] != '=') continue;
        ++at;
        std::string_view value;
        const char quote = at < line.size() ? line[at] : ' ';
        if (quote == '"' || quote == '{') {
            const auto end = std::min(line.find(quote == '"' ? '"' : '}', at + 1), line.size());
            value = line.substr(at + 1, end - at - 1);
            at = std::min(end + 1, line.size());
        } else {
            const auto end = std::min(line.find_first_of(" \t", at), line.size());
            value = line.substr(at, end - at);
            at = end;
        }
        if (equalsNoCase(word, key)) return value;
    }
    return {};
}

/// Names of the columns by `species:S:1:pos:R:3:...`.
std::vector<std::string> columnsOf(std::string_view properties, const InputFile& file) {
    const std::vector<std::string> words = splitAt(properties, ':');
    if (properties.empty() || words.size() % 3 != 0)
        file.failAtLine(
            "does not describe the columns; write it as extended XYZ, with "
            "Properties=species:S:1:pos:R:3:radius:R:1, name the columns with `columns`, or set "
            "`packRadius` for elements and positions without radii");
    std::vector<std::string> names;
    // A row takes two bytes for each of its columns.
    const std::uint64_t most = (file.size() - file.offset()) / 2 + 100;
    for (std::size_t w = 0; w < words.size(); w += 3) {
        const std::string& name = words[w];
        std::int64_t count = 0;
        if (name.empty() || words[w + 1].size() != 1 ||
            std::string_view("SRIL").find(words[w + 1]) == std::string_view::npos ||
            !parseNumber(words[w + 2], count) || count < 1 || count > 1000)
            file.failAtLine(fmt::format(
                "'{:.40}:{:.40}:{:.40}' describes no column; write name:S, R, I or L:count", name,
                words[w + 1], words[w + 2]));
        if (names.size() + static_cast<std::uint64_t>(count) > most)
            file.failAtLine(fmt::format(
                "announces more than {} columns, too many for what follows; correct it", most));
        if (name == "pos" && count == 3)
            names.insert(names.end(), {"x", "y", "z"});
        else
            addNames(names, name, static_cast<std::uint64_t>(count));
    }
    return names;
}

/// The box by `pbc`, `Lattice` and `Origin`; nothing without a lattice.
std::optional<StatedBox> boxOf(std::string_view description, Unit unit, const InputFile& file) {
    Cells wraps, lattice, origin;
    splitAtBlanks(valueOf(description, "pbc"), wraps);
    splitAtBlanks(valueOf(description, "lattice"), lattice);
    splitAtBlanks(valueOf(description, "origin"), origin);
    if (lattice.empty()) return std::nullopt;
    StatedBox stated;
    stated.hasFlags = wraps.size() == 3;
    bool sound = lattice.size() == 9;
    for (std::size_t k = 0; sound && k < 9; ++k) {
        const std::size_t d = k / 4;
        double v = 0, lo = 0;
        sound = parseNumber(lattice[k], v);
        stated.isTilted = stated.isTilted || (k % 4 != 0 && v != 0);
        if (k % 4 != 0) continue;
        if (origin.size() == 3) sound = sound && parseNumber(origin[d], lo);
        const auto axis = static_cast<int>(d);
        stated.cell.box.lo[axis] = toMillimeters(lo, unit);
        stated.cell.box.hi[axis] = toMillimeters(lo + v, unit);
        if (!stated.hasFlags) continue;
        const std::string wrap = lowered(std::string(wraps[d]));
        stated.cell.wraps[d] = wrap == "t" || wrap == "true" || wrap == "1";
    }
    if (!sound)
        file.failAtLine(
            fmt::format("Lattice {} is not nine numbers, or Origin not three; correct it",
                        quotedExcerpt(valueOf(description, "lattice"))));
    return stated;
}

/// Whether a column says of every sphere that it has no species.
bool saysNothing(const Column& column) {
    return column.name == kXyzSpecies && column.numbers.empty() &&
           std::all_of(column.texts.begin(), column.texts.end(),
                       [](const std::string& text) { return text == kXyzNoSpecies; });
}

/// @param count  of particles, which the line before announces.
Pack<3> readFrame(InputFile& file, std::uint64_t count, const PackReadOptions& options) {
    std::string_view line;
    if (!file.nextLine(line))
        file.fail("ends before the line that describes the columns; the file is cut short");
    TextTable table;
    const auto properties = valueOf(line, "properties");
    if (!properties.empty())
        table.names = columnsOf(properties, file);
    else if (!options.columns.inOrder.empty())
        table.names = options.columns.inOrder;
    else if (options.radius > 0)  // plain: elements and their positions
        table.names = {std::string(kXyzSpecies), "x", "y", "z"};
    else
        columnsOf({}, file);
    table.options = options;
    table.rows = count;
    if (const auto name = valueOf(line, kUnitKey); !name.empty())
        table.options.unit = unitIn(kUnitComment + std::string(name), table.options.unit, file);
    table.nextRow = [&](Cells& cells) { return nextWords(file, table.names, cells); };
    const auto box = boxOf(line, table.options.unit, file);
    const PackOrigin origin = originIn(line);
    Pack<3> pack = readTable(file, table);
    pack.origin = origin;
    if (box) takeCell(pack, *box, file.path(), options.callbacks);
    auto& columns = pack.columns;
    columns.erase(std::remove_if(columns.begin(), columns.end(), saysNothing), columns.end());
    return pack;
}

}  // namespace

Pack<3> readXyz(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    std::string_view line;
    std::optional<Pack<3>> pack;  // of several frames the last one
    while (file.nextLine(line)) {
        if (trimmed(line).empty()) continue;
        std::int64_t count = 0;
        if (!parseNumber(line, count) || count < 0)
            file.failAtLine(
                fmt::format("'{:.40}' is not a number of particles; an .xyz file begins with one",
                            trimmed(line)));
        pack = readFrame(file, static_cast<std::uint64_t>(count), options);
    }
    if (!pack) file.fail("is empty; an .xyz file is needed");
    return *std::move(pack);
}

}  // namespace vdbpack
