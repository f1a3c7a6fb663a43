#include "vdbpack/io/number_table.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

NumberTable::NumberTable(const std::string& path, const std::string& expected)
    : text_(path), expected_(expected) {
    text_.readHeader(expected);
    for (const auto& name : text_.names()) canonical_.push_back(canonicalName(name));
}

std::optional<std::size_t> NumberTable::find(const std::vector<std::string>& names) const {
    std::optional<std::size_t> found;
    for (std::size_t c = 0; c < canonical_.size(); ++c) {
        if (std::find(names.begin(), names.end(), canonical_[c]) == names.end()) continue;
        if (found)
            failColumns(fmt::format("columns '{}' and '{}' mean the same", text_.names()[*found],
                                    text_.names()[c]));
        found = c;
    }
    return found;
}

std::size_t NumberTable::require(const std::vector<std::string>& names) const {
    const auto found = find(names);
    if (!found) failColumns(fmt::format("no column '{}'", fmt::join(names, "' or '")));
    return *found;
}

double NumberTable::number(std::size_t column) const {
    double value = 0;
    if (!parseNumber(cells_[column], value) || !std::isfinite(value))
        failRow(fmt::format(
            "'{}' in column '{}' is not a finite number{}; correct or remove the row",
            cells_[column].substr(0, 60), text_.names()[column], numberRemedy(cells_[column])));
    return value;
}

void NumberTable::failColumns(const std::string& what) const {
    std::string names;
    for (const auto& name : text_.names()) names += (names.empty() ? "" : ",") + name.substr(0, 60);
    throw InputError(fmt::format("{}: line {}: {} among {}; name the columns {}",
                                 text_.file().path(), text_.headerLine(), what, names, expected_));
}

}  // namespace vdbpack
