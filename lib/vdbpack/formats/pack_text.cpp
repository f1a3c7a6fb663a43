#include "vdbpack/formats/pack_text.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/io/delimited_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

std::string escapedXml(std::string_view given) {
    const std::string line = oneLine(std::string(given));
    std::string out;
    for (std::string_view text = line; !text.empty();) {
        const std::size_t bytes = utf8Bytes(text);
        switch (text.front()) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                // Parsers of XML refuse bytes that are not UTF-8 (names of Latin-1 files).
                out += bytes > 0 ? text.substr(0, bytes) : std::string_view("\xef\xbf\xbd");
        }
        text.remove_prefix(std::max<std::size_t>(bytes, 1));
    }
    return out;
}

Unit unitNamed(std::string_view name, const std::string& where) {
    try {
        return parseUnit(std::string(trimmed(name)));
    } catch (const ParameterError&) {
        throw InputError(
            fmt::format("{}: unknown unit {}; use m, cm, mm or um", where, quotedExcerpt(name)));
    }
}

Unit unitIn(std::string_view comment, Unit unit, const InputFile& file) {
    const std::string_view key = kUnitComment;
    const auto at = comment.find(key);
    if (at == std::string_view::npos) return unit;
    return unitNamed(comment.substr(at + key.size()),
                     fmt::format("{}: line {}", file.path(), file.lineNumber()));
}

std::string partLines(const PackAttributes& pack) {
    std::string lines;
    for (const std::string& name : partNames(pack))
        lines += (lines.empty() ? "" : "\n") + oneLine(name);
    return lines;
}

std::string partComments(const PackAttributes& pack) {
    constexpr std::size_t kLongest = 200;  // LAMMPS reads lines of up to 255 characters
    std::string comments;
    const std::vector<std::string>& names = partNames(pack);
    for (std::size_t k = 0; k < names.size(); ++k)
        comments += fmt::format("# part {}: {:.{}}\n", k, oneLine(names[k]), kLongest);
    return comments;
}

bool takePartComment(std::string_view line, std::vector<std::string>& names) {
    if (!startsWith(line, "#")) return false;
    const std::string begin = fmt::format("# part {}: ", names.size());
    if (!startsWith(line, begin)) return false;
    names.emplace_back(trimmed(line.substr(begin.size())));
    return true;
}

std::string cellText(const PeriodicCell<3>& cell) {
    if (!cell.any()) return {};
    std::string text;
    for (int d = 0; d < 3; ++d)
        if (cell.isAlong(d)) text += "xyz"[d];
    for (const Vec<3>& corner : {cell.box.lo, cell.box.hi})
        for (const double c : corner.c) appendNumber(text += ' ', c);
    return text;
}

PeriodicCell<3> cellIn(std::string_view text, Unit unit, const std::string& where) {
    Cells words;
    splitAtBlanks(text, words);
    PeriodicCell<3> cell;
    bool sound = words.size() == 7;
    for (std::size_t k = 0; sound && k < words[0].size(); ++k) {
        const auto axis = std::string_view("xyz").find(words[0][k]);
        sound = axis != std::string_view::npos;
        if (sound) cell.wraps[axis] = true;
    }
    for (int d = 0; sound && d < 3; ++d) {
        const auto at = static_cast<std::size_t>(d);
        double lo = 0, hi = 0;
        sound = parseNumber(words[1 + at], lo) && parseNumber(words[4 + at], hi);
        cell.box.lo[d] = toMillimeters(lo, unit);
        cell.box.hi[d] = toMillimeters(hi, unit);
        if (cell.isAlong(d)) sound = sound && cell.length(d) > 0 && std::isfinite(cell.length(d));
    }
    if (!sound)
        throw InputError(fmt::format("{}: {} {} is no periodic cell; remove or correct it", where,
                                     kCellKey, quotedExcerpt(text)));
    return cell;
}

void takeCell(Pack<3>& pack, const StatedBox& stated, const std::string& file,
              const Callbacks& callbacks) {
    PeriodicCell<3> cell = stated.cell;
    bool isBox = !stated.isTilted;
    std::size_t protruding = 0;
    Box<3> around;
    for (const Sphere<3>& s : pack.spheres) {
        bool inside = true;
        for (int d = 0; d < 3; ++d)
            inside = inside && s.center[d] - 0.9 * s.radius >= cell.box.lo[d] &&
                     s.center[d] + 0.9 * s.radius <= cell.box.hi[d];
        protruding += inside ? 0 : 1;
        around.add(s.center - Box<3>::filled(s.radius));
        around.add(s.center + Box<3>::filled(s.radius));
    }
    for (int d = 0; d < 3; ++d) {
        const double length = cell.length(d);
        if (cell.isAlong(d)) isBox = isBox && length > 0 && std::isfinite(length);
        if (cell.isAlong(d) || pack.spheres.empty()) continue;
        cell.box.lo[d] = std::min(cell.box.lo[d], around.lo[d]);
        cell.box.hi[d] = std::max(cell.box.hi[d], around.hi[d]);
    }
    if (!stated.hasFlags && (stated.isTilted || protruding > 0))
        callbacks.warn(fmt::format(
            "{}: {}, and the file does not state which faces are periodic: overlap and contacts "
            "across faces are not counted. Name a periodic box as `domain` with `periodic`",
            file,
            stated.isTilted ? "its box is tilted (triclinic)"
                            : fmt::format("{} spheres protrude from its box", protruding)));
    else if (cell.any() && !isBox)
        callbacks.warn(fmt::format(
            "{}: its periodic box is {}; a periodic cell has edges along x, y and z. The pack has "
            "none: overlap and contacts across its faces are not counted",
            file, stated.isTilted ? "tilted (triclinic)" : "empty or without end"));
    else if (stated.hasFlags && cell.any())
        pack.cell = cell;
}

std::string UniqueNames::operator()(const std::string& name) {
    std::string candidate = name;
    for (int n = 2; !taken_.insert(lowered(candidate)).second; ++n)
        candidate = fmt::format("{}_{}", name, n);
    return candidate;
}

std::string identifierOf(std::string_view name) {
    std::string identifier(name);
    for (char& c : identifier) {
        const bool fits =
            (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
        if (!fits) c = '_';
    }
    return identifier;
}

bool takeLammpsUnits(std::string_view style, Unit& unit) {
    if (style == "si") unit = Unit::meter;
    if (style == "cgs") unit = Unit::centimeter;
    if (style == "micro") unit = Unit::micrometer;
    return style == "si" || style == "cgs" || style == "micro";
}

DensityUnit densityUnit(Unit unit) {
    constexpr DensityUnit kUnits[] = {
        {1, "kg/m3"},     // m: units si
        {1e3, "g/cm3"},   // cm: units cgs
        {1e12, "t/mm3"},  // mm: with s, forces in N and pressures in MPa
        {1e3, "pg/um3"},  // um: units micro
    };
    return kUnits[static_cast<std::size_t>(unit)];
}

void convertDensity(Pack<3>& pack, Unit unit) {
    for (Column& column : pack.columns) {
        if (column.name != "density" || columnOfNumbers(pack, kDensityColumn)) continue;
        column.name = kDensityColumn;
        for (double& density : column.numbers) density *= densityUnit(unit).size;
    }
}

}  // namespace vdbpack
