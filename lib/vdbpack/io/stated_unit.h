// Units of length by the words of comments and headers.
#pragma once

#include "vdbpack/core/units.h"

#include <optional>
#include <string_view>
#include <utility>

namespace vdbpack {

/// The unit of length that a word in small letters names.
inline std::optional<Unit> unitCalled(std::string_view word) {
    constexpr std::pair<std::string_view, Unit> kWords[] = {{"m", Unit::meter},
                                                            {"meter", Unit::meter},
                                                            {"metre", Unit::meter},
                                                            {"cm", Unit::centimeter},
                                                            {"mm", Unit::millimeter},
                                                            {"um", Unit::micrometer},
                                                            {"\u00b5m", Unit::micrometer},
                                                            {"\u03bcm", Unit::micrometer},
                                                            {"micron", Unit::micrometer},
                                                            {"microns", Unit::micrometer}};
    for (const auto& [known, unit] : kWords)
        if (word == known) return unit;
    return std::nullopt;
}

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
