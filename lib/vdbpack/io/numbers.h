// Private: numbers as text, exact both ways and without a locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// Appends `value` as `%.17g` would print it (reading it gives the same double), with a decimal
/// point: Blender does not read a column whose first value looks like `1e-05` or `3` as numbers.
void appendNumber(std::string& text, double value);
void appendNumber(std::string& text, std::int64_t value);
/// Appends the fewest digits that give `value` back, as float or as double; "nan", "inf" or "-inf"
/// for what is not finite.
void appendShortest(std::string& text, float value);
void appendShortest(std::string& text, double value);

/// The number in `text`, which may have blanks around it.
/// @return false, `value` untouched, if it is not one number within range.
bool parseNumber(std::string_view text, double& value);
/// The same for whole numbers, also where they are written as `3.0` or `1e3`.
bool parseNumber(std::string_view text, std::int64_t& value);

/// The number in `word`; a number too large for double is infinite, one too
/// small is 0. @return false for any other text, also if there are blanks around the number.
bool parseReal(std::string_view word, double& value);
/// The same for whole numbers without point and exponent, within range.
bool parseInteger(std::string_view word, std::int64_t& value);

/// What to do about a text that is no number: "; decimals have a point: 1.5" for 1,5, "; write 30 %
/// as 0.3" for 30%. Empty: nothing is known.
std::string numberRemedy(std::string_view text);

/// The finite numbers of a list such as "1,2.5,3"; nothing if it is none.
std::optional<std::vector<double>> parseNumberList(std::string_view text);

/// Bytes of a size such as "8G", "500 MB", "1.5GiB" or "65536": K, M, G and T are powers of 1024,
/// with or without iB; KB, MB, GB and TB of 1000. Nothing for anything else and for less than one
/// byte.
std::optional<double> parseBytes(std::string_view text);

/// `value` as a whole number; false if it is none or does not fit.
bool wholeNumber(double value, std::int64_t& whole);

}  // namespace vdbpack
