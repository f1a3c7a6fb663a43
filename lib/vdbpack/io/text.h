// Private: words, blanks and letters of texts, without a locale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// Whether `c` separates words of one line.
inline bool isBlank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// `text` without blanks at either end.
std::string_view trimmed(std::string_view text);

/// Takes words, which blanks separate, off the front of a text.
class Words {
public:
    explicit Words(std::string_view text) : text_(text) {}
    /// The next word; empty at the end.
    std::string_view next() {
        std::size_t begin = 0;
        while (begin < text_.size() && isBlank(text_[begin])) ++begin;
        std::size_t end = begin;
        while (end < text_.size() && !isBlank(text_[end])) ++end;
        const std::string_view word = text_.substr(begin, end - begin);
        text_.remove_prefix(end);
        return word;
    }
    /// The text after the words taken so far.
    std::string_view rest() const { return text_; }

private:
    std::string_view text_;
};

/// Replaces `words` by the words of `line`.
void splitAtBlanks(std::string_view line, std::vector<std::string_view>& words);

/// The texts between the separators of `text`, without blanks at their ends.
std::vector<std::string> splitAt(std::string_view text, char separator);

/// `text` with small letters for A to Z.
std::string lowered(std::string_view text);
/// Whether `text` is `lowerText`, which has no capital letters, in any case.
bool equalsNoCase(std::string_view text, std::string_view lowerText);
bool startsWith(std::string_view text, std::string_view beginning);
bool endsWith(std::string_view text, std::string_view end);

/// The extension of a file name with its dot, in small letters; empty if there is none.
std::string extensionOf(std::string_view path);

/// Bytes of the character of UTF-8 at the front of a text that is not empty; 0 if there is none.
std::size_t utf8Bytes(std::string_view text);

/// `text` with '?' for control characters, but line breaks and tabs, and for bytes that are no
/// UTF-8: fit for a terminal.
std::string printable(std::string_view text);

/// The first 40 bytes of `text` in single quotes, for a message; '?' for unprintable ones.
std::string quotedExcerpt(std::string_view text);

/// Whether a file can have this name: one with a NUL would be cut short there.
/// @throws IoError otherwise.
void requireFileName(const std::string& path);

/// `text` as one line of a comment: control characters become blanks.
std::string oneLine(std::string text);

/// Words of `text` in lines of at most `width` columns, the first continuing a line of `at`
/// columns, the others indented by `indent`. Words that are longer stand alone; line breaks in
/// `text` stay.
std::string wrapped(std::string_view text, std::size_t width, std::size_t indent, std::size_t at);

/// Appends a character of Unicode as UTF-8.
void appendUtf8(std::string& text, std::uint32_t character);

}  // namespace vdbpack
