#include "vdbpack/io/number_table.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// The most frequent of comma, semicolon and tab, or else the blank.
char separatorOf(std::string_view header) {
    char best = ' ';
    std::ptrdiff_t most = 0;
    for (const char c : {',', ';', '\t'}) {
        const auto count = std::count(header.begin(), header.end(), c);
        if (count > most) best = c;
        most = std::max(most, count);
    }
    return best;
}

void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
    if (separator == ' ') {
        splitAtBlanks(line, cells);
        return;
    }
    cells.clear();
    for (std::size_t at = 0;;) {
        const std::size_t end = std::min(line.find(separator, at), line.size());
        cells.push_back(trimmed(line.substr(at, end - at)));
        if (end == line.size()) return;
        at = end + 1;
    }
}

std::string_view unquoted(std::string_view cell) {
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"')
        cell = cell.substr(1, cell.size() - 2);
    return cell;
}

std::string canonicalName(std::string_view name) {
    name = name.substr(0, name.find_first_of("[("));
    std::string result;
    for (const char c : name) {
        const bool upper = c >= 'A' && c <= 'Z';
        const bool kept = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (c & 0x80) != 0;
        if (upper || kept) result += upper ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return result;
}

}  // namespace

NumberTable::NumberTable(const std::string& path, const std::string& expected)
    : file_(path), expected_(expected) {
    std::string_view line;
    while (file_.nextLine(line)) {
        if (file_.lineNumber() == 1 && line.substr(0, 3) == "\xef\xbb\xbf") line.remove_prefix(3);
        const auto content = trimmed(line);
        if (content.empty()) continue;
        if (content.front() == '#') {
            if (takeHeader(content.substr(1)) && find({"x"})) return;
            continue;
        }
        if (takeHeader(line)) return;
        throw InputError(fmt::format(
            "{}: line {}: holds numbers where the columns must be named; put a line {} above it",
            path, file_.lineNumber(), expected));
    }
    throw InputError(
        fmt::format("{}: is empty; the first line must name the columns {}", path, expected));
}

bool NumberTable::takeHeader(std::string_view line) {
    separator_ = separatorOf(line);
    split(line, separator_, cells_);
    names_.clear();
    canonical_.clear();
    headerLine_ = file_.lineNumber();
    double ignored = 0;
    bool words = false;
    for (const auto cell : cells_) {
        names_.emplace_back(unquoted(cell));
        canonical_.push_back(canonicalName(names_.back()));
        words = words || !parseNumber(cell, ignored);
    }
    return words;
}

std::optional<std::size_t> NumberTable::find(const std::vector<std::string>& names) const {
    std::optional<std::size_t> found;
    for (std::size_t c = 0; c < canonical_.size(); ++c) {
        if (std::find(names.begin(), names.end(), canonical_[c]) == names.end()) continue;
        if (found)
            failColumns(
                fmt::format("columns '{}' and '{}' mean the same", names_[*found], names_[c]));
        found = c;
    }
    return found;
}

std::size_t NumberTable::require(const std::vector<std::string>& names) const {
    const auto found = find(names);
    if (!found) failColumns(fmt::format("no column '{}'", names.front()));
    return *found;
}

bool NumberTable::nextRow() {
    std::string_view line;
    while (file_.nextLine(line)) {
        const auto content = trimmed(line);
        if (content.empty() || content.front() == '#') continue;
        split(line, separator_, cells_);
        for (auto& cell : cells_) cell = unquoted(cell);
        if (cells_.size() != names_.size())
            failRow(fmt::format("has {} cells where line {} names {} columns; complete the line",
                                cells_.size(), headerLine_, names_.size()));
        return true;
    }
    return false;
}

double NumberTable::number(std::size_t column) const {
    double value = 0;
    if (!parseNumber(cells_[column], value) || !std::isfinite(value))
        failRow(fmt::format("'{}' in column '{}' is not a finite number; correct or remove the row",
                            cells_[column].substr(0, 60), names_[column]));
    return value;
}

void NumberTable::failRow(const std::string& what) const {
    throw InputError(fmt::format("{}: line {}: {}", file_.path(), file_.lineNumber(), what));
}

void NumberTable::failColumns(const std::string& what) const {
    std::string names;
    for (const auto& name : names_) names += (names.empty() ? "" : ",") + name.substr(0, 60);
    throw InputError(fmt::format("{}: line {}: {} among {}; name the columns {}", file_.path(),
                                 headerLine_, what, names, expected_));
}

}  // namespace vdbpack
