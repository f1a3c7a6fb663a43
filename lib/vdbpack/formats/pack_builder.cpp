#include "vdbpack/formats/pack_builder.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

std::string lowered(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

template <typename T>
bool fits(std::int64_t value) {
    return value >= std::numeric_limits<T>::min() && value <= std::numeric_limits<T>::max();
}

}  // namespace

void dropDefaultIds(Pack<3>& pack) {
    for (std::size_t i = 0; i < pack.id.size(); ++i)
        if (pack.id[i] != static_cast<std::int64_t>(i)) return;
    pack.id = {};
}

PackBuilder::PackBuilder(std::string file, const std::vector<std::string>& names, Unit unit)
    : file_(std::move(file)), unit_(unit), names_(names), roles_(names.size()) {
    std::vector<std::string> low;
    low.reserve(names.size());
    for (const auto& name : names) low.push_back(lowered(name));
    // A malformed header may have any number of columns: sort instead of comparing all pairs.
    auto sorted = low;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end())
        throw InputError(
            fmt::format("{}: column '{}' appears twice; rename one of them", file_, *twice));

    const auto claim = [&](Role role, std::initializer_list<const char*> synonyms) {
        for (const char* synonym : synonyms) {
            const auto at = std::find(low.begin(), low.end(), synonym);
            if (at == low.end()) continue;
            roles_[static_cast<std::size_t>(at - low.begin())].role = role;
            return true;
        }
        return false;
    };
    const bool complete =
        claim(Role::x, {"x", "points:0", "points_0"}) &&
        claim(Role::y, {"y", "points:1", "points_1"}) &&
        claim(Role::z, {"z", "points:2", "points_2"}) &&
        (claim(Role::radius, {"radius", "r", "pscale"}) || claim(Role::diameter, {"diameter"}));
    if (!complete) {
        std::string known;
        for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 20); ++i)
            known += (i > 0 ? ", " : "") + names[i].substr(0, 40);
        throw InputError(fmt::format(
            "{}: columns x, y, z and radius (or r, pscale, diameter) are needed, found: {}; name "
            "the columns",
            file_, known.empty() ? "none" : known));
    }
    claim(Role::id, {"id"});
    claim(Role::region, {"region"});
    claim(Role::order, {"order"});
    claim(Role::depth, {"depth"});
    claim(Role::contacts, {"contacts"});
    for (std::size_t i = 0; i < roles_.size(); ++i) {
        if (roles_[i].role != Role::further) continue;
        roles_[i].index = pack_.columns.size();
        pack_.columns.push_back({names[i], {}, {}});
    }
}

bool PackBuilder::isWhole(std::size_t column) const {
    switch (roles_[column].role) {
        case Role::id:
        case Role::region:
        case Role::order:
        case Role::contacts:
            return true;
        default:
            return false;
    }
}

void PackBuilder::reserve(std::size_t rows) {
    pack_.spheres.reserve(rows);
    for (const auto& r : roles_) {
        switch (r.role) {
            case Role::id:
                pack_.id.reserve(rows);
                break;
            case Role::region:
                pack_.region.reserve(rows);
                break;
            case Role::order:
                pack_.order.reserve(rows);
                break;
            case Role::depth:
                pack_.depth.reserve(rows);
                break;
            case Role::contacts:
                pack_.contacts.reserve(rows);
                break;
            case Role::further:
                if (!r.text) pack_.columns[r.index].numbers.reserve(rows);
                break;
            default:
                break;
        }
    }
}

void PackBuilder::addRow() {
    pack_.spheres.emplace_back();
    for (const auto& r : roles_) {
        switch (r.role) {
            case Role::id:
                pack_.id.push_back(0);
                break;
            case Role::region:
                pack_.region.push_back(0);
                break;
            case Role::order:
                pack_.order.push_back(0);
                break;
            case Role::depth:
                pack_.depth.push_back(0);
                break;
            case Role::contacts:
                pack_.contacts.push_back(0);
                break;
            case Role::further:
                if (r.text)
                    pack_.columns[r.index].texts.emplace_back();
                else
                    pack_.columns[r.index].numbers.push_back(0);
                break;
            default:
                break;
        }
    }
}

bool PackBuilder::set(std::size_t column, double value) {
    const auto& r = roles_[column];
    switch (r.role) {
        case Role::x:
            pack_.spheres.back().center[0] = toMillimeters(value, unit_);
            return true;
        case Role::y:
            pack_.spheres.back().center[1] = toMillimeters(value, unit_);
            return true;
        case Role::z:
            pack_.spheres.back().center[2] = toMillimeters(value, unit_);
            return true;
        case Role::radius:
            pack_.spheres.back().radius = toMillimeters(value, unit_);
            return true;
        case Role::diameter:
            pack_.spheres.back().radius = toMillimeters(value / 2, unit_);
            return true;
        case Role::depth:
            value = toMillimeters(value, unit_);
            // Beyond float's range the conversion is undefined.
            if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
                return false;
            pack_.depth.back() = static_cast<float>(value);
            return true;
        case Role::further:
            pack_.columns[r.index].numbers.back() = value;
            return true;
        default: {
            std::int64_t whole = 0;
            return wholeNumber(value, whole) && set(column, whole);
        }
    }
}

bool PackBuilder::set(std::size_t column, std::int64_t value) {
    switch (roles_[column].role) {
        case Role::id:
            pack_.id.back() = value;
            return true;
        case Role::order:
            pack_.order.back() = value;
            return true;
        case Role::region:
            pack_.region.back() = static_cast<std::int32_t>(value);
            return fits<std::int32_t>(value);
        case Role::contacts:
            pack_.contacts.back() = static_cast<std::int32_t>(value);
            return fits<std::int32_t>(value);
        default:
            return set(column, static_cast<double>(value));
    }
}

void PackBuilder::setText(std::size_t column, std::string_view value) {
    pack_.columns[roles_[column].index].texts.back() = value;
}

bool PackBuilder::parse(std::size_t column, std::string_view text) {
    if (roles_[column].text) {
        setText(column, text);
        return true;
    }
    if (isWhole(column)) {
        std::int64_t whole = 0;
        return parseNumber(text, whole) && set(column, whole);
    }
    double value = 0;
    return parseNumber(text, value) && set(column, value);
}

std::string PackBuilder::problem() const {
    const auto& s = pack_.spheres.back();
    if (!isFinite(s.center))
        return fmt::format("center ({}, {}, {}) is not finite; remove or correct the sphere",
                           s.center[0], s.center[1], s.center[2]);
    if (!(s.radius > 0) || !std::isfinite(s.radius))
        return fmt::format("radius is {}; it must be positive and finite", s.radius);
    return {};
}

void PackBuilder::failCell(const std::string& where, std::size_t column,
                           std::string_view value) const {
    throw InputError(fmt::format("{}: {}: column '{}' is '{}'; a {} is needed there", file_, where,
                                 names_[column].substr(0, 40), value.substr(0, 40),
                                 isWhole(column) ? "whole number" : "number"));
}

void PackBuilder::failRow(const std::string& where) const {
    throw InputError(file_ + ": " + where + ": " + problem());
}

Pack<3> PackBuilder::finish() {
    dropDefaultIds(pack_);
    return std::move(pack_);
}

}  // namespace vdbpack
