#include "vdbpack/formats/materials.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::int32_t kMost = 2147483646;
/// Combinations of part, region and class, of which a table is made.
constexpr double kMostKeys = 1e7;

/// The numbers of a column that counts something.
const std::vector<double>* countedIn(const PackAttributes& pack, const char* name) {
    if (columnOfNumbers(pack, "type")) return nullptr;
    const Column* column = columnOfNumbers(pack, name);
    const auto isCount = [](double v) { return v >= 0 && v < kMost && v == std::floor(v); };
    return column && std::all_of(column->numbers.begin(), column->numbers.end(), isCount)
               ? &column->numbers
               : nullptr;
}

double largest(const std::vector<double>& numbers) {
    return *std::max_element(numbers.begin(), numbers.end());
}

}  // namespace

const Column* columnOfNumbers(const PackAttributes& pack, const char* name) {
    for (const Column& column : pack.columns)
        if (column.name == name && !column.numbers.empty()) return &column;
    return nullptr;
}

const std::vector<std::string>& partNames(const PackAttributes& pack) {
    static const std::vector<std::string> kNone;
    const Column* const parts = columnOfNumbers(pack, kPartColumn);
    return parts ? parts->names : kNone;
}

void setPartNames(PackAttributes& pack, std::vector<std::string> names) {
    for (Column& column : pack.columns)
        if (column.name == kPartColumn && !column.numbers.empty()) column.names = std::move(names);
}

Materials::Materials(const PackAttributes& pack)
    : pack_(pack), parts_(countedIn(pack, kPartColumn)), classes_(countedIn(pack, kClassColumn)) {
    for (const std::int32_t region : pack.region)
        if (region < 0 || region >= kMost)
            throw ParameterError(fmt::format(
                "regions are written as materials, and one of them is {}; number them from 0",
                region));
    if (!pack.region.empty())
        regions_ = 1 + *std::max_element(pack.region.begin(), pack.region.end());
    if (regions_ == 1 && (parts_ || classes_)) regions_ = 0;  // there are not several
    const double plain = (parts_ ? largest(*parts_) + 1 : 1) * std::max(regions_, 1);
    if (plain > kMost)
        throw ParameterError(fmt::format("{} parts of {} regions are too many materials",
                                         largest(*parts_) + 1, regions_));
    if (!classes_) return;
    const double classes = largest(*classes_) + 1;
    if (plain * classes > kMostKeys) {
        classes_ = nullptr;
        return;
    }
    classCount_ = static_cast<std::size_t>(classes);
    const auto found = [&](std::size_t i) { return keyOf(withoutClass(i), (*classes_)[i]); };
    rank_.assign(static_cast<std::size_t>(plain) * classCount_, 0);
    for (std::size_t i = 0; i < classes_->size(); ++i) rank_[found(i)] = 1;
    std::int32_t next = 0;
    for (std::int32_t& rank : rank_) rank = rank ? next++ : -1;
}

Materials::Kind Materials::kindOf(std::int32_t material) const {
    std::int32_t plain = material, densityClass = 0;
    if (classes_) {
        const auto key = std::find(rank_.begin(), rank_.end(), material) - rank_.begin();
        plain = static_cast<std::int32_t>(static_cast<std::size_t>(key) / classCount_);
        densityClass = static_cast<std::int32_t>(static_cast<std::size_t>(key) % classCount_);
    }
    const std::int32_t regions = std::max(regions_, 1);
    return {plain / regions, plain % regions, densityClass};
}

MaterialNumbers::MaterialNumbers(std::string_view text, std::string_view word) {
    const auto at = text.find(word);
    if (at == std::string_view::npos) return;
    const std::string_view rest = text.substr(at + word.size());
    formula = std::string(rest.substr(0, rest.find(';')));
    const auto end = formula.find(" part + region");
    std::int64_t stated = 0;
    constexpr std::int64_t kMostRegions = 1000;
    if (end != std::string::npos && parseNumber(formula.substr(0, end), stated) && stated > 0 &&
        stated <= kMostRegions)
        regions = static_cast<std::int32_t>(stated);
}

void MaterialNumbers::split(PackAttributes& pack) const {
    if (regions == 0 || pack.region.empty()) return;
    Column part;
    part.name = kPartColumn;
    for (std::int32_t& region : pack.region) {
        part.numbers.push_back(region / regions);
        region %= regions;
    }
    pack.columns.push_back(std::move(part));
}

std::string Materials::formula() const {
    if (classes_) {
        std::string of;
        if (parts_) of += "part, ";
        if (regions_ > 0) of += "region, ";
        return fmt::format("number of ({}density class)", of);
    }
    if (!parts_) return regions_ > 0 ? "region" : "";
    return regions_ > 0 ? fmt::format("{} part + region", regions_) : kPartColumn;
}

SphereDensities::SphereDensities(const PackAttributes& pack, double all,
                                 std::map<std::int32_t, double> ofMaterials)
    : materials_(pack),
      all_(all > 0 ? all : kDefaultDensity),
      ofMaterials_(std::move(ofMaterials)) {
    if (all > 0 || !ofMaterials_.empty()) return;
    const auto usable = [](double v) { return v >= 0 && std::isfinite(v); };
    const auto usableColumn = [&](const char* name) {
        const Column* column = columnOfNumbers(pack, name);
        return column && std::all_of(column->numbers.begin(), column->numbers.end(), usable) &&
                       largest(column->numbers) > 0
                   ? column
                   : nullptr;
    };
    column_ = usableColumn(kDensityColumn);
    if (!column_) unconverted_ = usableColumn("density");
}

double SphereDensities::of(std::size_t i) const {
    if (column_ && column_->numbers[i] > 0) return column_->numbers[i];
    return requested(materials_.withoutClass(i));
}

double SphereDensities::of(const Materials::Kind& kind) const {
    return requested(materials_.withoutClass(kind.part, kind.region));
}

double SphereDensities::requested(std::int32_t material) const {
    const auto found = ofMaterials_.find(material);
    return found != ofMaterials_.end() ? found->second : all_;
}

}  // namespace vdbpack
