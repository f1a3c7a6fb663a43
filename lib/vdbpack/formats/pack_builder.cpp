#include "vdbpack/formats/pack_builder.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/delimited_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/stated_unit.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace vdbpack {

void addNames(std::vector<std::string>& names, const std::string& name, std::uint64_t components) {
    for (std::uint64_t c = 0; c < components; ++c)
        names.push_back(components == 1 ? name : fmt::format("{}_{}", name, c));
}

void dropDefaultIds(Pack<3>& pack) {
    for (std::size_t i = 0; i < pack.id.size(); ++i)
        if (pack.id[i] != static_cast<std::int64_t>(i)) return;
    pack.id = {};
}

PackBuilder::PackBuilder(std::string file, std::vector<std::string> names,
                         const PackReadOptions& options)
    : file_(std::move(file)),
      options_(options),
      names_(std::move(names)),
      columns_(names_.size(), Numbers(nullptr)) {
    rename();
    for (const auto& name : names_) {
        low_.push_back(lowered(name));
        quantities_.push_back(columnName(name).quantity);
    }
    // A malformed header may have any number of columns: sort instead of comparing all pairs.
    auto sorted = low_;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) failTwice(*twice, *twice);
    hasRadii_ = claim(radius, {"radius", "r", "pscale", "radii", "scalarradius", "rad",
                               "particleradius", "sphereradius"}) ||
                claim(diameter, {"diameter", "diameters", "scalardiameter", "diam",
                                 "particlediameter", "spherediameter"});
    bool complete = hasRadii_ || options_.radius > 0;
    for (const Quantity axis : {x, y, z}) complete = claim(axis, axisNames(axis)) && complete;
    if (!complete) failIncomplete();
    forEachAttribute(pack_, [&](std::string_view name, auto& values) {
        const auto at = std::find(low_.begin(), low_.end(), name) - low_.begin();
        const auto column = static_cast<std::size_t>(at);
        if (column < low_.size() && isFurther(column)) columns_[column] = &values;
    });
    for (std::size_t i = 0; i < names_.size(); ++i)
        if (isFurther(i)) pack_.columns.push_back({names_[i], {}, {}});
    // From here on the vector of columns does not move.
    auto further = pack_.columns.begin();
    for (std::size_t i = 0; i < names_.size(); ++i)
        if (isFurther(i)) columns_[i] = &(further++)->numbers;
}

void PackBuilder::rename() {
    const auto& [inOrder, renamed] = options_.columns;
    if (!inOrder.empty() && inOrder.size() != names_.size())
        failRow(fmt::format("has {} columns, and `columns` names {}; name each of them",
                            names_.size(), inOrder.size()));
    if (!inOrder.empty()) names_ = inOrder;
    for (const auto& [name, from] : renamed) {
        const auto at = std::find_if(names_.begin(), names_.end(), [&wanted = from](const auto& n) {
            return lowered(n) == lowered(wanted);
        });
        if (at == names_.end()) failIncomplete(from);
        const std::string unit = columnName(*at).unit;
        // A unit that is not known is dropped: the caller says what the column is.
        const bool keeps = columnName(name).unit.empty() && unitCalled(unit);
        *at = keeps ? fmt::format("{} [{}]", name, unit) : name;
    }
}

bool PackBuilder::claim(Quantity quantity, const std::vector<std::string>& synonyms) {
    for (const std::string& synonym : synonyms) {
        std::optional<std::size_t> found;
        const auto exact = std::find(low_.begin(), low_.end(), synonym);
        if (exact != low_.end()) found = static_cast<std::size_t>(exact - low_.begin());
        for (std::size_t i = 0; exact == low_.end() && i < names_.size(); ++i) {
            if (quantities_[i] != synonym) continue;
            if (found) failTwice(names_[*found], names_[i]);
            found = i;
        }
        if (!found) continue;
        columns_[*found] = SphereNumber{quantity, unitOf(names_[*found])};
        return true;
    }
    return false;
}

Unit PackBuilder::unitOf(const std::string& name) const {
    const std::string word = columnName(name).unit;
    if (word.empty()) return options_.unit;
    const auto unit = unitCalled(word);
    if (!unit)
        failRow(
            fmt::format("the unit '{:.40}' of column '{:.40}' is not known; use m, cm, mm or um, "
                        "or rename the column with `columns`",
                        word, name));
    return *unit;
}

void PackBuilder::failTwice(const std::string& first, const std::string& second) const {
    failRow(fmt::format("column '{:.40}' appears twice{}; rename one of them", first,
                        first == second ? "" : fmt::format(" (again as '{:.40}')", second)));
}

void PackBuilder::failIncomplete(const std::string& wanted) const {
    std::string known;
    for (std::size_t i = 0; i < std::min<std::size_t>(names_.size(), 20); ++i)
        known += (i > 0 ? ", " : "") + names_[i].substr(0, 40);
    failRow(fmt::format(
        "{} needed, found: {}; name the columns in the file or with `columns`{}",
        wanted.empty()
            ? "columns x, y, z and radius (or r, pscale, radii, scalar_radius, diameter) are"
            : fmt::format("column '{:.40}' is", wanted),
        known.empty() ? "none" : known,
        wanted.empty() ? ", or set `packRadius` where there are no radii" : ""));
}

bool PackBuilder::isWhole(std::size_t column) const {
    return std::holds_alternative<std::vector<std::int32_t>*>(columns_[column]) ||
           std::holds_alternative<std::vector<std::int64_t>*>(columns_[column]);
}

void PackBuilder::makeText(std::size_t column) {
    if (!isFurther(column))
        throw InputError(fmt::format("{}: column '{}' holds texts; numbers are needed", file_,
                                     names_[column].substr(0, 40)));
    const auto further = std::find_if(pack_.columns.begin(), pack_.columns.end(),
                                      [numbers = std::get<Numbers>(columns_[column])](
                                          const Column& c) { return &c.numbers == numbers; });
    columns_[column] = &further->texts;
}

template <class Use>
void PackBuilder::forEachColumn(const Use& use) const {
    for (const Target& target : columns_)
        std::visit(
            [&use](auto values) {
                if constexpr (std::is_pointer_v<decltype(values)>) use(*values);
            },
            target);
}

double PackBuilder::bytesOf(std::uint64_t rows) const {
    std::size_t row = sizeof(Sphere<3>);
    forEachColumn([&row](auto& values) { row += sizeof(values[0]); });
    return static_cast<double>(row) * static_cast<double>(rows);
}

void PackBuilder::reserve(std::size_t rows) {
    pack_.spheres.reserve(rows);
    forEachColumn([rows](auto& values) { values.reserve(rows); });
}

void PackBuilder::addRow() {
    pack_.spheres.emplace_back().radius = options_.radius;
    forEachColumn([](auto& values) { values.emplace_back(); });
}

void PackBuilder::setSphere(SphereNumber number, double value) {
    Sphere<3>& sphere = pack_.spheres.back();
    if (number.quantity < radius)
        sphere.center[number.quantity] = toMillimeters(value, number.unit);
    else
        sphere.radius = toMillimeters(number.quantity == diameter ? value / 2 : value, number.unit);
}

bool PackBuilder::set(std::size_t column, double value) {
    if (isWhole(column)) {
        std::int64_t whole = 0;
        return wholeNumber(value, whole) && set(column, whole);
    }
    if (const auto* number = std::get_if<SphereNumber>(&columns_[column])) {
        setSphere(*number, value);
        return true;
    }
    if (const auto* lengths = std::get_if<std::vector<float>*>(&columns_[column])) {
        const double length = toMillimeters(value, options_.unit);
        // Beyond float's range the conversion is undefined.
        if (std::abs(length) > static_cast<double>(std::numeric_limits<float>::max())) return false;
        (*lengths)->back() = static_cast<float>(length);
        return true;
    }
    std::get<Numbers>(columns_[column])->back() = value;
    return true;
}

bool PackBuilder::set(std::size_t column, std::int64_t value) {
    if (const auto* wide = std::get_if<std::vector<std::int64_t>*>(&columns_[column])) {
        (*wide)->back() = value;
        return true;
    }
    if (const auto* narrow = std::get_if<std::vector<std::int32_t>*>(&columns_[column])) {
        std::int32_t& cell = (*narrow)->back();
        cell = static_cast<std::int32_t>(value);
        return cell == value;
    }
    return set(column, static_cast<double>(value));
}

void PackBuilder::setText(std::size_t column, std::string_view value) {
    std::get<Texts>(columns_[column])->back() = value;
}

bool PackBuilder::parse(std::size_t column, std::string_view text) {
    if (isText(column)) {
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
    throw InputError(fmt::format("{}: {}: column '{}' is '{}'; a {} is needed there{}", file_,
                                 where, names_[column].substr(0, 40), value.substr(0, 40),
                                 isWhole(column) ? "whole number" : "number", numberRemedy(value)));
}

void PackBuilder::failRow(const std::string& what) const {
    throw InputError(file_ + ": " + what);
}

PackBuilder::Put PackBuilder::numbersFrom(const char* first, std::size_t stride, NumberType type,
                                          bool swap) {
    return [=](std::size_t column, std::uint64_t row) {
        return loadNumber(type, first + row * stride, swap,
                          [&](auto value) { return set(column, value); });
    };
}

PackBuilder::Put PackBuilder::textsFrom(const std::vector<std::string>& texts) {
    return [this, &texts](std::size_t column, std::uint64_t row) {
        setText(column, texts[row]);
        return true;
    };
}

void PackBuilder::addRows(std::uint64_t count, const std::vector<Put>& puts, const char* what,
                          std::uint64_t first) {
    for (std::uint64_t row = 0; row < count; ++row) {
        const auto where = [&] { return fmt::format("{} {}", what, first + row); };
        addRow();
        for (std::size_t c = 0; c < puts.size(); ++c)
            if (!puts[c](c, row)) failCell(where(), c, "out of range");
        checkRow(where);
    }
}

bool PackBuilder::repeatsRadius(const Column& column) const {
    return hasRadii_ && columnName(lowered(column.name)).quantity == "diameter";
}

void PackBuilder::requireSpheres() const {
    // Axes and exponents of superquadrics and ellipsoids, in MFiX, LIGGGHTS and LAMMPS.
    constexpr std::string_view kAxes[] = {"sqp_a", "sqp_b", "sqp_c", "shapex", "shapey", "shapez"};
    constexpr std::string_view kExponents[] = {"sqp_m", "sqp_n", "blockiness1", "blockiness2"};
    const std::vector<double>* axis = nullptr;
    const auto differ = [](double a, double b) { return std::abs(a - b) > 1e-5 * std::abs(b); };
    for (const Column& column : pack_.columns) {
        if (column.numbers.empty()) continue;
        const std::string name = lowered(column.name);
        const bool isDiameter = repeatsRadius(column);
        const auto isOneOf = [&name](const auto& names) {
            return std::find(std::begin(names), std::end(names), name) != std::end(names);
        };
        const bool isAxis = isOneOf(kAxes), isExponent = isOneOf(kExponents);
        const Unit unit = isDiameter ? unitOf(column.name) : options_.unit;
        if (isAxis && !axis) axis = &column.numbers;
        for (std::size_t i = 0; i < column.numbers.size() && (isAxis || isExponent || isDiameter);
             ++i) {
            const double v = column.numbers[i];
            if (isDiameter && differ(toMillimeters(v, unit), 2 * pack_.spheres[i].radius))
                failRow(fmt::format(
                    "row {}: column '{}' is {}, and the radius is {}; remove or rename the one "
                    "that "
                    "is not the size of the spheres",
                    i, column.name, v, fromMillimeters(pack_.spheres[i].radius, unit)));
            if ((isAxis && differ(v, (*axis)[i])) || (isExponent && differ(v, 2)))
                failRow(fmt::format(
                    "row {}: column '{}' is {}: the particle is no sphere but an ellipsoid or a "
                    "superquadric; remove the column to take the radii of all as spheres",
                    i, column.name, v));
        }
    }
}

Pack<3> PackBuilder::finish() {
    requireSpheres();
    std::vector<Column>& further = pack_.columns;
    further.erase(std::remove_if(further.begin(), further.end(),
                                 [this](const Column& c) { return repeatsRadius(c); }),
                  further.end());
    if (hasRadii_ && options_.radius > 0)
        options_.callbacks.warn(file_ + ": has radii of its own; `packRadius` is not used");
    if (options_.requestedUnit != Unit::millimeter && options_.requestedUnit != options_.unit)
        options_.callbacks.warn(
            fmt::format("{}: states that its lengths are in {}; `packUnit` {} is not used", file_,
                        unitName(options_.unit), unitName(options_.requestedUnit)));
    dropDefaultIds(pack_);
    return std::move(pack_);
}

}  // namespace vdbpack
