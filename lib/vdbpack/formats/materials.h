// What spheres are made of, for programs that know materials by number.
#pragma once

#include "vdbpack/core/pack.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The column of a pack of several parts: which one a sphere fills, counted from 0.
inline constexpr const char* kPartColumn = "part";

/// Materials of a pack, counted from 0: its regions, or its parts; where parts have several
/// regions, those of each part one after another (part 1, region 0 of two: 2).
///
/// Parts are those of `kPartColumn`, if it has whole numbers from 0 and the pack has no column
/// `type`, which says more.
class Materials {
public:
    /// @throws ParameterError for regions that are negative, or too many materials.
    explicit Materials(const PackAttributes& pack);

    /// Whether the pack says anything of them.
    bool any() const { return regions_ > 0 || parts_; }
    bool hasParts() const { return parts_ != nullptr; }
    std::int32_t partOf(std::size_t i) const { return static_cast<std::int32_t>((*parts_)[i]); }
    std::int32_t of(std::size_t i) const {
        const std::int32_t region = regions_ > 0 ? pack_.region[i] : 0;
        return parts_ ? of(partOf(i), region) : region;
    }
    std::int32_t of(std::int32_t part, std::int32_t region) const {
        return regions_ > 0 ? part * regions_ + region : part;
    }
    /// Such as "region", "part" or "2 part + region".
    std::string formula() const;

private:
    const PackAttributes& pack_;
    std::int32_t regions_ = 0;                    // the largest + 1; 0: there are none
    const std::vector<double>* parts_ = nullptr;  // null: there are none
};

}  // namespace vdbpack
