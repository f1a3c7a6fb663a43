#include "vdbpack/pack/size_table.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/delimited_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/stated_unit.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string_view>

namespace vdbpack {

namespace {

enum class Quantity { radius, diameter, weight, finer, coarser };

struct SizeColumn {
    Quantity quantity;
    Unit unit = Unit::millimeter;
};

bool isOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

/// Words of a name in small letters, without signs: "Sieve size [mm]" as sieve, size, mm.
std::vector<std::string> wordsOf(std::string_view name) {
    std::vector<std::string> words(1);
    for (const char c : lowered(name)) {
        if (std::string_view(" \t_-[]().:/").find(c) == std::string_view::npos)
            words.back() += c;
        else if (!words.back().empty())
            words.emplace_back();
    }
    if (words.back().empty()) words.pop_back();
    return words;
}

/// What a column of this name holds; nothing if a word of the name is not understood.
std::optional<SizeColumn> columnNamed(std::string_view name, SizeTable kind) {
    std::optional<Quantity> quantity;
    std::optional<Unit> unit;
    bool isPercent = false;
    for (const std::string& word : wordsOf(name)) {
        std::optional<Quantity> named;
        if (isOneOf(word, {"radius", "radii", "r"})) named = Quantity::radius;
        if (isOneOf(word, {"diameter", "diameters", "d", "size", "opening", "aperture"}))
            named = Quantity::diameter;
        if (kind == SizeTable::weights &&
            isOneOf(word, {"weight", "weights", "w", "count", "number", "share", "frequency"}))
            named = Quantity::weight;
        if (kind == SizeTable::sieve && isOneOf(word, {"finer", "passing", "passed", "undersize"}))
            named = Quantity::finer;
        if (kind == SizeTable::sieve && isOneOf(word, {"coarser", "retained", "oversize"}))
            named = Quantity::coarser;
        const bool isFiller =
            isOneOf(word, {"sieve", "grain", "particle", "sphere", "cumulative", "cum"}) ||
            isOneOf(word, {"by", "mass", "percent", "%", "wt%", "pct"});
        if (named && (!quantity || *quantity == *named))
            quantity = named;
        else if (!unit && unitCalled(word))
            unit = unitCalled(word);
        else if (named || !isFiller)
            return std::nullopt;
        isPercent = isPercent || isOneOf(word, {"percent", "%", "wt%", "pct", "mass"});
    }
    if (!quantity) return std::nullopt;
    const bool isLength = *quantity == Quantity::radius || *quantity == Quantity::diameter;
    if (isLength ? isPercent : unit.has_value()) return std::nullopt;
    if (*quantity == Quantity::weight && isPercent) return std::nullopt;
    return SizeColumn{*quantity, unit.value_or(Unit::millimeter)};
}

/// The columns by their names, a length and another quantity; nothing if they are not these.
std::vector<SizeColumn> columnsNamed(const std::vector<std::string>& names, SizeTable kind) {
    std::vector<SizeColumn> columns;
    int lengths = 0;
    for (const std::string& name : names) {
        const auto column = columnNamed(name, kind);
        if (!column) return {};
        columns.push_back(*column);
        lengths += column->quantity == Quantity::radius || column->quantity == Quantity::diameter;
    }
    return columns.size() == 2 && lengths == 1 ? columns : std::vector<SizeColumn>{};
}

/// Joins what is in brackets to the word before it: "d", "[mm]".
std::vector<std::string> namesIn(const Cells& cells) {
    std::vector<std::string> names;
    for (const std::string_view cell : cells)
        if (!names.empty() && !cell.empty() && (cell[0] == '[' || cell[0] == '('))
            names.back().append(" ").append(cell);
        else
            names.emplace_back(cell);
    return names;
}

/// The columns that a comment above the rows names; nothing if there is none.
std::vector<SizeColumn> columnsInComments(const std::string& path, SizeTable kind) {
    InputFile file(path);
    file.skipByteOrderMark();
    std::string_view line;
    std::vector<SizeColumn> columns;
    while (file.nextLine(line) && (trimmed(line).empty() || trimmed(line)[0] == '#')) {
        Cells cells;
        std::string words(line.substr(std::min(line.find('#') + 1, line.size())));
        std::replace_if(
            words.begin(), words.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
        splitAtBlanks(words, cells);
        if (auto named = columnsNamed(namesIn(cells), kind); !named.empty()) columns = named;
    }
    return columns;
}

}  // namespace

std::vector<std::pair<double, double>> readSizeTable(const std::string& path, SizeTable kind) {
    constexpr std::size_t kMostRows = 1000000;
    const bool isSieve = kind == SizeTable::sieve;
    const char* const expected = isSieve ? "diameter,percent finer by mass" : "radius,weight";
    std::vector<SizeColumn> columns = columnsInComments(path, kind);
    const auto isLength = [&](std::size_t i) {
        return columns[i].quantity == Quantity::radius || columns[i].quantity == Quantity::diameter;
    };
    DelimitedText text(path);
    std::vector<std::pair<double, double>> rows;
    Cells cells;
    for (bool first = true; text.nextRow(cells); first = false) {
        while (cells.size() > 2 && cells.back().empty()) cells.pop_back();
        double value[2] = {0, 0};
        bool good = cells.size() == 2;
        for (std::size_t i = 0; i < 2 && good; ++i)
            good = parseNumber(cells[i], value[i]) && std::isfinite(value[i]);
        const auto shown = fmt::format("{}", fmt::join(cells, ", ")).substr(0, 60);
        double number = 0;
        if (!good && first && !parseNumber(cells[0], number)) {
            columns = columnsNamed(namesIn(cells), kind);
            if (columns.empty())
                text.file().failAtLine(fmt::format(
                    "columns '{}' are not understood; give two, named {} (radius or diameter, with "
                    "a unit as in diameter_um{})",
                    shown, expected,
                    isSieve ? "; finer or passing, coarser or retained, in percent"
                            : "; weights by volume: `weight-by` volume"));
            continue;
        }
        if (!good)
            text.file().failAtLine(fmt::format(
                "'{}' is not two numbers; expected columns {}; decimals have a point, such as 0.5",
                shown, expected));
        if (columns.empty())
            columns = {{isSieve ? Quantity::diameter : Quantity::radius},
                       {isSieve ? Quantity::finer : Quantity::weight}};
        const std::size_t at = isLength(0) ? 0 : 1;
        double length = toMillimeters(value[at], columns[at].unit), share = value[1 - at];
        if (isSieve && columns[at].quantity == Quantity::radius) length *= 2;
        if (!isSieve && columns[at].quantity == Quantity::diameter) length /= 2;
        if (columns[1 - at].quantity == Quantity::coarser) share = 100 - share;
        rows.emplace_back(length, share);
        if (rows.size() > kMostRows)
            throw InputError(path + ": more than a million rows; give a coarser table");
    }
    if (rows.empty())
        throw InputError(fmt::format("{}: no rows; expected columns {}", path, expected));
    return rows;
}

}  // namespace vdbpack
