// Private to verify: bits of numbers mixed into hashes.
#pragma once

#include <cstdint>
#include <cstring>

namespace vdbpack {

/// What a hash starts with: 2^64 divided by the golden ratio.
inline constexpr std::uint64_t kHashStart = 0x9e3779b97f4a7c15ull;

/// SplitMix64's finalizer: a bijection on 64 bits with full avalanche.
/// Source: Steele, Lea, Flood (2014), doi:10.1145/2714064.2660195 (Stafford's mix 13).
inline std::uint64_t mixedBits(std::uint64_t h) {
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ h >> 27) * 0x94d049bb133111ebull;
    return h ^ h >> 31;
}

/// The bits of a number; -0 has those of 0.
inline std::uint64_t bitsOfNumber(double v) {
    v += 0.0;
    std::uint64_t bits;
    std::memcpy(&bits, &v, sizeof bits);
    return bits;
}

}  // namespace vdbpack
