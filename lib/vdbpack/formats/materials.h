// What spheres are made of, for programs that know materials by number.
#pragma once

#include "vdbpack/core/pack.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace vdbpack {

/// Materials of a pack, counted from 0: its regions, or its parts; where it has both, the regions
/// of each part one after another (part 1, region 0 of two: 2).
class Materials {
public:
    /// @throws ParameterError for regions and parts that are negative.
    explicit Materials(const PackAttributes& pack);

    /// Whether the pack says anything of them.
    bool any() const { return regions_ > 0 || parts_; }
    std::int32_t of(std::size_t i) const {
        const std::int32_t region = regions_ > 0 ? pack_.region[i] : 0;
        return parts_ ? pack_.part[i] * (regions_ > 0 ? regions_ : 1) + region : region;
    }
    std::int32_t of(std::int32_t part, std::int32_t region) const {
        return part * (regions_ > 0 ? regions_ : 1) + (regions_ > 0 ? region : 0);
    }
    /// Such as "region", "part" or "2 part + region".
    std::string formula() const;

private:
    const PackAttributes& pack_;
    std::int32_t regions_ = 0;  // the largest + 1; 0: there are none
    bool parts_ = false;
};

}  // namespace vdbpack
