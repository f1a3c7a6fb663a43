#include "vdbpack/formats/pack_text.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/delimited_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

namespace vdbpack {

namespace {

/// Replaces bytes that are not UTF-8 (names of Latin-1 files) by U+FFFD: parsers of XML refuse
/// them.
std::string asUtf8(const std::string& text) {
    const bool ascii = std::all_of(text.begin(), text.end(),
                                   [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    if (ascii) return text;
    using nlohmann::json;
    return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace))
        .get<std::string>();
}

}  // namespace

std::string escapedXml(std::string_view text) {
    std::string out;
    for (const char c : asUtf8(oneLine(std::string(text)))) {
        switch (c) {
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
                out += c;
        }
    }
    return out;
}

bool parseUnitComment(std::string_view comment, Unit& unit) {
    const std::string_view key = kUnitComment;
    const auto at = comment.find(key);
    if (at == std::string_view::npos) return true;
    auto name = comment.substr(at + key.size());
    while (!name.empty() && (name.back() == ' ' || name.back() == '\r')) name.remove_suffix(1);
    try {
        unit = parseUnit(std::string(name));
    } catch (const ParameterError&) {
        return false;
    }
    return true;
}

double metersPer(Unit unit) {
    switch (unit) {
        case Unit::meter:
            return 1;
        case Unit::centimeter:
            return 0.01;
        case Unit::millimeter:
            return 0.001;
        case Unit::micrometer:
            return 1e-6;
    }
    return 1;
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

std::optional<PeriodicCell<3>> parseCellText(std::string_view text, Unit unit) {
    Cells words;
    splitAtBlanks(text, words);
    if (words.size() != 7) return std::nullopt;
    PeriodicCell<3> cell;
    for (const char c : words[0]) {
        const auto axis = std::string_view("xyz").find(c);
        if (axis == std::string_view::npos) return std::nullopt;
        cell.wraps[axis] = true;
    }
    for (int d = 0; d < 3; ++d) {
        const auto at = static_cast<std::size_t>(d);
        double lo = 0, hi = 0;
        if (!parseNumber(words[1 + at], lo) || !parseNumber(words[4 + at], hi)) return std::nullopt;
        cell.box.lo[d] = toMillimeters(lo, unit);
        cell.box.hi[d] = toMillimeters(hi, unit);
        if (cell.isAlong(d) && !(cell.length(d) > 0 && std::isfinite(cell.length(d))))
            return std::nullopt;
    }
    return cell;
}

void takeLammpsUnits(std::string_view style, Unit& unit) {
    if (style == "si") unit = Unit::meter;
    if (style == "cgs") unit = Unit::centimeter;
    if (style == "micro") unit = Unit::micrometer;
}

}  // namespace vdbpack
