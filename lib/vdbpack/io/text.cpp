#include "vdbpack/io/text.h"

#include "vdbpack/core/error.h"

#include <algorithm>

namespace vdbpack {

namespace {
char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
}  // namespace

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
    while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
    return text;
}

void splitAtBlanks(std::string_view line, std::vector<std::string_view>& words) {
    words.clear();
    Words rest(line);
    for (auto word = rest.next(); !word.empty(); word = rest.next()) words.push_back(word);
}

std::vector<std::string> splitAt(std::string_view text, char separator) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(separator, begin), text.size());
        parts.emplace_back(trimmed(text.substr(begin, end - begin)));
        begin = end + 1;
    }
    return parts;
}

std::string lowered(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), lower);
    return result;
}

bool equalsNoCase(std::string_view text, std::string_view lowerText) {
    return std::equal(text.begin(), text.end(), lowerText.begin(), lowerText.end(),
                      [](char a, char b) { return lower(a) == b; });
}

bool startsWith(std::string_view text, std::string_view beginning) {
    return text.substr(0, beginning.size()) == beginning;
}

bool endsWith(std::string_view text, std::string_view end) {
    return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

std::string extensionOf(std::string_view path) {
    const std::string_view name = path.substr(path.find_last_of('/') + 1);
    const std::size_t dot = name.find_last_of('.');
    return dot == std::string_view::npos ? "" : lowered(name.substr(dot));
}

std::size_t utf8Bytes(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    if (lead < 0x80) return 1;
    const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    if (lead < 0xc2 || lead > 0xf4 || bytes > text.size()) return 0;
    std::uint32_t character = lead & (0x7fU >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        const auto next = static_cast<unsigned char>(text[i]);
        if ((next & 0xc0) != 0x80) return 0;
        character = character << 6 | (next & 0x3fU);
    }
    constexpr std::uint32_t kLeast[] = {0, 0, 0xa0, 0x800, 0x10000};  // 0x80 to 0x9f are controls
    const bool surrogate = character >= 0xd800 && character < 0xe000;
    return character >= kLeast[bytes] && character <= 0x10ffff && !surrogate ? bytes : 0;
}

std::string printable(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const char c = text.front();
        const bool control =
            (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
        const std::size_t bytes = control ? 0 : utf8Bytes(text);
        out += bytes > 0 ? text.substr(0, bytes) : std::string_view("?");
        text.remove_prefix(std::max<std::size_t>(bytes, 1));
    }
    return out;
}

std::string quotedExcerpt(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    std::size_t end = std::min(kLongest, text.size());
    // Not within a character.
    while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80)
        --end;
    std::string out = printable(text.substr(0, end));
    std::replace_if(
        out.begin(), out.end(), [](char c) { return c == '\n' || c == '\t'; }, '?');
    return "'" + out + (text.size() > kLongest ? "...'" : "'");
}

void requireFileName(const std::string& path) {
    const auto nul = path.find('\0');
    if (nul != std::string::npos)
        throw IoError(path + ": its character " + std::to_string(nul + 1) +
                      " is a NUL, which no name of a file contains. Give another name");
}

std::string oneLine(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    return text;
}

std::string wrapped(std::string_view text, std::size_t width, std::size_t indent, std::size_t at) {
    std::string out;
    bool first = true;
    std::size_t breaks = 0;
    for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
        end = std::min(text.find_first_of(" \n", begin), text.size());
        const std::string_view word = text.substr(begin, end - begin);
        const auto columns =
            static_cast<std::size_t>(std::count_if(word.begin(), word.end(), [](char c) {
                return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
            }));
        if (columns > 0) {
            if (!first && breaks == 0 && at + 1 + columns > width) breaks = 1;
            const bool joins = !first && breaks == 0;
            if (breaks > 0) at = indent;
            for (; breaks > 0; --breaks) out += '\n' + std::string(indent, ' ');
            (out += joins ? " " : "") += word;
            at += columns + joins;
            first = false;
        }
        breaks += end < text.size() && text[end] == '\n';
    }
    return out;
}

void appendUtf8(std::string& text, std::uint32_t character) {
    const auto put = [&text](std::uint32_t byte) { text += static_cast<char>(byte); };
    const auto putRest = [&](int shift) { put(0x80 | (character >> shift & 0x3f)); };
    if (character < 0x80) {
        put(character);
    } else if (character < 0x800) {
        put(0xc0 | character >> 6);
        putRest(0);
    } else if (character < 0x10000) {
        put(0xe0 | character >> 12);
        putRest(6);
        putRest(0);
    } else {
        put(0xf0 | (character >> 18 & 7));
        putRest(12);
        putRest(6);
        putRest(0);
    }
}

}  // namespace vdbpack
