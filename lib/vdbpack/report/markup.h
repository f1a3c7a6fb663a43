// Text and figures as HTML.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Text as the content of an element or a quoted attribute: &, <, >, quotes escaped; bytes that are
/// no UTF-8 and control characters that XML forbids become U+FFFD.
std::string escaped(const std::string& text);

/// Bytes in the letters of RFC 4648, for data URIs.
std::string base64(const std::string& bytes);

/// Six digits, for people; a dash where it is not finite.
std::string figureText(double value);

/// A table with a row for each pair of name and value, both escaped here.
std::string pairTable(const std::vector<std::pair<std::string, std::string>>& rows);

/// All values of a JSON report: a <section> with a table for each object in it, long columns of
/// numbers folded away in tables of their own.
/// @param plane  words for circles and areas.
std::string figureTables(const nlohmann::ordered_json& figures, bool plane);

}  // namespace vdbpack
