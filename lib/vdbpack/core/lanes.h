// Eight floats at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <experimental/simd>

namespace vdbpack {

namespace stdx = std::experimental;

/// Eight lanes on every machine, in one register where there is one: the same result everywhere.
inline constexpr std::size_t kLanes = 8;
using Lanes = stdx::simd<float, stdx::simd_abi::deduce_t<float, kLanes>>;

inline Lanes load(const float* p) {
    return Lanes(p, stdx::element_aligned);
}

/// `n` rounded up to whole lanes.
inline constexpr std::size_t padded(std::size_t n) {
    return (n + kLanes - 1) / kLanes * kLanes;
}

/// Calls `visit(lane)` for the lanes that are set, by rising number.
template <class Visit>
[[gnu::always_inline]] inline void forEachSet(const Lanes::mask_type& mask, Visit visit) {
    bool set[kLanes];
    mask.copy_to(set, stdx::element_aligned);
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    static_assert(sizeof set == sizeof(std::uint64_t));
    std::uint64_t bits;
    std::memcpy(&bits, set, sizeof bits);
    for (; bits != 0; bits &= bits - 1) visit(static_cast<std::size_t>(__builtin_ctzll(bits)) / 8);
#else
    for (std::size_t l = 0; l < kLanes; ++l)
        if (set[l]) visit(l);
#endif
}

/// `yes` where the mask is set, else `no`.
[[gnu::always_inline]] inline Lanes choose(const Lanes::mask_type& mask, Lanes yes,
                                           const Lanes& no) {
    where(!mask, yes) = no;
    return yes;
}
inline float choose(bool mask, float yes, float no) {
    return mask ? yes : no;
}

}  // namespace vdbpack
