#include "vdbpack/io/numbers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace vdbpack {

namespace {
std::string_view withoutSign(std::string_view text) {
    // from_chars knows no plus sign; "+-1" must stay wrong.
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    return text;
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

bool parseNumber(std::string_view text, double& value) {
    text = withoutSign(trimmed(text));
    double parsed = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
    if (error != std::errc() || end != text.data() + text.size()) return false;
    value = parsed;
    return true;
}

bool parseNumber(std::string_view text, std::int64_t& value) {
    text = withoutSign(trimmed(text));
    std::int64_t parsed = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
    if (error == std::errc() && end == text.data() + text.size()) {
        value = parsed;
        return true;
    }
    double real = 0;
    return parseNumber(text, real) && wholeNumber(real, value);
}

bool wholeNumber(double value, std::int64_t& whole) {
    // Above 2^63 the conversion is undefined; written this way NaN fails too.
    if (!(std::abs(value) < 0x1p63) || std::trunc(value) != value) return false;
    whole = static_cast<std::int64_t>(value);
    return true;
}

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

void splitAtBlanks(std::string_view line, std::vector<std::string_view>& words) {
    words.clear();
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    for (std::size_t at = 0;;) {
        while (at < line.size() && blank(line[at])) ++at;
        if (at >= line.size()) return;
        const std::size_t begin = at;
        while (at < line.size() && !blank(line[at])) ++at;
        words.push_back(line.substr(begin, at - begin));
    }
}

}  // namespace vdbpack
