// Counter-based random streams: the value depends on (seed, stream, index) alone.
#pragma once

#include <cstdint>

namespace vdbpack {

/// SplitMix64's finalizer, a bijection on 64 bits with full avalanche.
/// Source: Steele, Lea, Flood (2014), doi:10.1145/2714064.2660195 (Stafford's mix 13).
inline std::uint64_t mix64(std::uint64_t x) {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9ull;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebull;
    x ^= x >> 31;
    return x;
}

/// A stream of random numbers keyed by (seed, stream), the same on every machine and for every
/// order in which streams are used. Copyable; not shared between threads.
class RandomStream {
public:
    RandomStream(std::uint64_t seed, std::uint64_t stream)
        : key_(mix64(seed + 0x9e3779b97f4a7c15ull) ^ mix64(mix64(stream + 0x632be59bd9b4e019ull))) {
    }

    /// 64 random bits.
    std::uint64_t bits() { return mix64(key_ + 0x9e3779b97f4a7c15ull * ++counter_); }
    /// Uniform in [0, 1), a multiple of 2^-53.
    double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

private:
    std::uint64_t key_;
    std::uint64_t counter_ = 0;
};

}  // namespace vdbpack
