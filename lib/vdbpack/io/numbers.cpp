#include "vdbpack/io/numbers.h"

#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace vdbpack {

namespace {

/// What all of `word` stands for. @return errc{} for a number, result_out_of_range for one that
/// does not fit, invalid_argument for any other text.
template <typename T>
std::errc parseWord(std::string_view word, T& value) {
    // from_chars accepts no plus sign; "+-1" must stay wrong.
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, value);
    return result.ptr == end ? result.ec : std::errc::invalid_argument;
}

/// Whether a number that is out of range is too small rather than too large.
bool isTiny(std::string_view word) {
    const std::size_t exponent = word.find_first_of("eE");
    return exponent != std::string_view::npos ? word.substr(exponent + 1, 1) == "-"
                                              : word.find_first_not_of("+-0.") > word.find('.');
}

template <typename T>
void appendFewestDigits(std::string& text, T value) {
    char buffer[40];
    // Some readers know no sign before "nan".
    const T shown = std::isnan(value) ? std::abs(value) : value;
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, shown).ptr);
}

}  // namespace

void appendNumber(std::string& text, double value) {
    char buffer[40];
    char* end =
        std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 17).ptr;
    char* exponent = std::find(buffer, end, 'e');
    const bool plain =
        std::all_of(buffer, exponent, [](char c) { return (c >= '0' && c <= '9') || c == '-'; });
    text.append(buffer, exponent);
    if (plain) text += ".0";
    text.append(exponent, end);
}

void appendNumber(std::string& text, std::int64_t value) {
    char buffer[24];
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

void appendShortest(std::string& text, float value) {
    appendFewestDigits(text, value);
}

void appendShortest(std::string& text, double value) {
    appendFewestDigits(text, value);
}

bool parseReal(std::string_view word, double& value) {
    const std::errc error = parseWord(word, value);
    if (error == std::errc::result_out_of_range)
        value = isTiny(word) ? 0.0 : std::numeric_limits<double>::infinity();
    return error != std::errc::invalid_argument;
}

bool parseInteger(std::string_view word, std::int64_t& value) {
    return parseWord(word, value) == std::errc{};
}

bool parseNumber(std::string_view text, double& value) {
    double parsed = 0;
    if (parseWord(trimmed(text), parsed) != std::errc{}) return false;
    value = parsed;
    return true;
}

bool parseNumber(std::string_view text, std::int64_t& value) {
    std::int64_t parsed = 0;
    if (parseWord(trimmed(text), parsed) == std::errc{}) {
        value = parsed;
        return true;
    }
    double real = 0;
    return parseNumber(text, real) && wholeNumber(real, value);
}

std::string numberRemedy(std::string_view text) {
    const bool percent = endsWith(text, "%");
    std::string pointed(text.substr(0, text.size() - percent));
    std::replace(pointed.begin(), pointed.end(), ',', '.');
    double value = 0;
    if (pointed == text || !parseNumber(pointed, value)) return {};
    return percent ? fmt::format("; write {:g} % as {:g}", value, value / 100)
                   : "; decimals have a point: " + pointed;
}

std::optional<std::vector<double>> parseNumberList(std::string_view text) {
    std::vector<double> values;
    for (std::size_t at = 0;;) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        double value = 0;
        if (!parseNumber(text.substr(at, end - at), value) || !std::isfinite(value))
            return std::nullopt;
        values.push_back(value);
        if (end == text.size()) return values;
        at = end + 1;
    }
}

std::optional<double> parseBytes(std::string_view text) {
    const std::size_t end = text.find_last_of("0123456789.") + 1;
    double value = 0;
    if (!parseReal(text.substr(0, end), value)) return std::nullopt;
    const std::string unit = lowered(trimmed(text.substr(end)));
    if (!unit.empty() && unit != "b") {
        const auto power = std::string_view("kmgt").find(unit.front());
        const std::string rest = unit.substr(1);
        if (power == std::string_view::npos || !(rest.empty() || rest == "b" || rest == "ib"))
            return std::nullopt;
        value *= std::pow(rest == "b" ? 1000.0 : 1024.0, static_cast<double>(power + 1));
    }
    if (!(value >= 1) || !std::isfinite(value)) return std::nullopt;
    return value;
}

bool wholeNumber(double value, std::int64_t& whole) {
    // Above 2^63 the conversion is undefined; written this way NaN fails too.
    if (!(std::abs(value) < 0x1p63) || std::trunc(value) != value) return false;
    whole = static_cast<std::int64_t>(value);
    return true;
}

}  // namespace vdbpack
