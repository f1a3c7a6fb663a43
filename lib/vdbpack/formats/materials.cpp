#include "vdbpack/formats/materials.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr std::int32_t kMost = 2147483646;

const std::vector<double>* partsOf(const PackAttributes& pack) {
    const std::vector<double>* parts = nullptr;
    for (const Column& column : pack.columns) {
        if (column.name == "type" && !column.numbers.empty()) return nullptr;
        if (column.name == kPartColumn && !column.numbers.empty()) parts = &column.numbers;
    }
    const auto isPart = [](double v) { return v >= 0 && v < kMost && v == std::floor(v); };
    return parts && std::all_of(parts->begin(), parts->end(), isPart) ? parts : nullptr;
}

}  // namespace

Materials::Materials(const PackAttributes& pack) : pack_(pack), parts_(partsOf(pack)) {
    for (const std::int32_t region : pack.region)
        if (region < 0 || region >= kMost)
            throw ParameterError(fmt::format(
                "regions are written as materials, and one of them is {}; number them from 0",
                region));
    if (!pack.region.empty())
        regions_ = 1 + *std::max_element(pack.region.begin(), pack.region.end());
    if (!parts_) return;
    if (regions_ == 1) regions_ = 0;  // no part has several
    const double last = *std::max_element(parts_->begin(), parts_->end());
    if (regions_ > 0 && (last + 1) * regions_ > kMost)
        throw ParameterError(
            fmt::format("{} parts of {} regions are too many materials", last + 1, regions_));
}

std::string Materials::formula() const {
    if (!parts_) return regions_ > 0 ? "region" : "";
    return regions_ > 0 ? fmt::format("{} part + region", regions_) : kPartColumn;
}

}  // namespace vdbpack
