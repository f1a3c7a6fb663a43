#include "vdbpack/formats/materials.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace vdbpack {

Materials::Materials(const PackAttributes& pack) : pack_(pack), parts_(!pack.part.empty()) {
    constexpr std::int32_t kMost = 2147483646;
    for (const auto* values : {&pack.region, &pack.part})
        for (const std::int32_t value : *values)
            if (value < 0 || value >= kMost)
                throw ParameterError(fmt::format(
                    "regions and parts are written as materials, and one of them is {}; number "
                    "them from 0",
                    value));
    if (!pack.region.empty())
        regions_ = 1 + *std::max_element(pack.region.begin(), pack.region.end());
    if (parts_ && regions_ == 1) regions_ = 0;  // no part has several
    if (parts_ && pack.part.size() > 0 && regions_ > 0) {
        const std::int32_t last = *std::max_element(pack.part.begin(), pack.part.end());
        if (last >= kMost / regions_)
            throw ParameterError(
                fmt::format("{} parts of {} regions are too many materials", last, regions_));
    }
}

std::string Materials::formula() const {
    if (!parts_) return regions_ > 0 ? "region" : "";
    return regions_ > 0 ? fmt::format("{} part + region", regions_) : "part";
}

}  // namespace vdbpack
