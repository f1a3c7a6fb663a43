// The unit of length that a file of ours states in a comment or header.
#pragma once

#include "vdbpack/core/units.h"

#include <optional>
#include <string_view>

namespace vdbpack {

/// Name of the unit in the metadata of .vdb, .vtp and .npz files of ours.
inline constexpr const char* kUnitKey = "unit_of_length";

/// The unit after `kUnitComment` in a comment or header; nothing if it states none of ours.
inline std::optional<Unit> statedUnit(std::string_view comment) {
    const auto at = comment.find(kUnitComment);
    if (at == std::string_view::npos) return std::nullopt;
    const auto name = comment.substr(at + std::string_view(kUnitComment).size());
    for (const Unit unit : {Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer})
        if (name.substr(0, name.find_first_of("; \t\r\n")) == unitName(unit)) return unit;
    return std::nullopt;
}

}  // namespace vdbpack
