// Private: words, blanks and letters of texts, without a locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vdbpack {

/// `text` with small letters for A to Z.
std::string lowered(std::string_view text);

/// `text` as one line of a comment: control characters become blanks.
std::string oneLine(std::string text);

/// Appends a character of Unicode as UTF-8.
void appendUtf8(std::string& text, std::uint32_t character);

}  // namespace vdbpack
