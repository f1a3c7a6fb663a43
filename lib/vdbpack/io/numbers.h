// Private: numbers as text, exact both ways and without a locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// Appends `value` as `%.17g` would print it (the same double comes back), always with a decimal
/// point: Blender takes a column whose first value looks like `1e-05` or `3` for something else.
void appendNumber(std::string& text, double value);
void appendNumber(std::string& text, std::int64_t value);

/// The number that all of `text` stands for, blanks around it aside.
/// @return false, `value` untouched, if it is not one number within range.
bool parseNumber(std::string_view text, double& value);
/// The same for whole numbers, also where they are written as `3.0` or `1e3`.
bool parseNumber(std::string_view text, std::int64_t& value);

/// `value` as a whole number; false if it is none or does not fit.
bool wholeNumber(double value, std::int64_t& whole);

/// `text` without blanks at either end.
std::string_view trimmed(std::string_view text);

/// Replaces `words` by those of `line`, which blanks and tabs separate.
void splitAtBlanks(std::string_view line, std::vector<std::string_view>& words);

}  // namespace vdbpack
