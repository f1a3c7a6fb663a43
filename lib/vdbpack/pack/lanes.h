// Private to pack: eight floats at a time.
#pragma once

#include <cstddef>
#include <experimental/simd>

namespace vdbpack {

namespace stdx = std::experimental;

/// Eight lanes on every machine, whatever its registers: the same pack everywhere.
inline constexpr std::size_t kLanes = 8;
using Lanes = stdx::fixed_size_simd<float, kLanes>;

inline Lanes load(const float* p) {
    return Lanes(p, stdx::element_aligned);
}

/// `n` rounded up to whole lanes.
inline constexpr std::size_t padded(std::size_t n) {
    return (n + kLanes - 1) / kLanes * kLanes;
}

/// Calls `visit(lane)` for the lanes that are set, by rising number.
template <class Visit>
void forEachSet(Lanes::mask_type mask, Visit visit) {
    while (any_of(mask)) {
        const int lane = find_first_set(mask);
        mask[static_cast<std::size_t>(lane)] = false;
        visit(static_cast<std::size_t>(lane));
    }
}

}  // namespace vdbpack
