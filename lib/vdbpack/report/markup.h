// Texts and numbers as HTML.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Text as the content of an element or a quoted attribute: &, <, > and quotes are escaped; bytes
/// that are not UTF-8, and control characters that XML forbids, become U+FFFD.
std::string escaped(const std::string& text);

/// Bytes in base 64 (RFC 4648), for data URIs.
std::string base64(const std::string& bytes);

/// A number with six digits; a dash if it is not finite.
std::string figureText(double value);

/// A table with a row for each pair of name and value. Escapes both.
std::string pairTable(const std::vector<std::pair<std::string, std::string>>& rows);

/// All values of a JSON report: a <section> with a table for each object in it, and a collapsed
/// table for each group of long columns of numbers.
/// @param plane  whether the report is of circles.
std::string figureTables(const nlohmann::ordered_json& figures, bool plane);

}  // namespace vdbpack
