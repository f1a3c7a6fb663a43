// Private to densify: eight numbers at a time, gathered from all over.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace vdbpack {

/// A sphere as the relaxation sees it, in units of the quantum; 2D: `z` is 0.
///
/// Positions are the low 32 bits of the whole ones: differences of near spheres come out right,
/// however large the domain, since they are taken modulo 2^32.
struct alignas(16) Body {
    std::uint32_t x = 0, y = 0, z = 0;
    float radius = 0;
};
static_assert(sizeof(Body) == 16);

/// A whole position, in quanta.
using Home = std::array<std::int64_t, 3>;

/// The low bits of a coordinate, as a `Body` has them.
inline std::uint32_t lowBits(std::int64_t v) {
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(v));
}

/// Whether low bits tell how far apart two positions are.
inline bool isNear(const Home& a, const Home& b) {
    for (std::size_t d = 0; d < 3; ++d)
        if (a[d] - b[d] > (std::int64_t(1) << 30) || b[d] - a[d] > (std::int64_t(1) << 30))
            return false;
    return true;
}

using Float8 [[gnu::vector_size(32)]] = float;
using Int8 [[gnu::vector_size(32)]] = std::int32_t;
using Word8 [[gnu::vector_size(32)]] = std::uint32_t;
using Word4 [[gnu::vector_size(16)]] = std::uint32_t;

/// Eight bodies, component by component.
struct Bodies8 {
    Word8 x, y, z;
    Float8 radius;
};

#define VDBPACK_INLINE [[gnu::always_inline]] inline

template <class To, class From>
VDBPACK_INLINE To bitsAs(From from) {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    std::memcpy(&to, &from, sizeof to);
    return to;
}

VDBPACK_INLINE Bodies8 byComponent(const Word4* b) {
    const auto joined = [](Word4 low, Word4 high) {
        return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
    };
    const Word8 r0 = joined(b[0], b[4]), r1 = joined(b[1], b[5]);
    const Word8 r2 = joined(b[2], b[6]), r3 = joined(b[3], b[7]);
    const Word8 xy01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13);
    const Word8 zr01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15);
    const Word8 xy23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
    const Word8 zr23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
    return {__builtin_shufflevector(xy01, xy23, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(xy01, xy23, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(zr01, zr23, 0, 1, 8, 9, 4, 5, 12, 13),
            bitsAs<Float8>(__builtin_shufflevector(zr01, zr23, 2, 3, 10, 11, 6, 7, 14, 15))};
}

/// Bodies at `ids[0]` to `ids[7]` of `all`.
VDBPACK_INLINE Bodies8 gather(const Body* all, const std::uint32_t* ids) {
    Word4 b[8];
    for (int l = 0; l < 8; ++l) std::memcpy(&b[l], all + ids[l], sizeof b[l]);
    return byComponent(b);
}
/// Eight bodies in a row.
VDBPACK_INLINE Bodies8 load(const Body* first) {
    Word4 b[8];
    std::memcpy(b, first, sizeof b);
    return byComponent(b);
}

template <class Number, class Octet>
VDBPACK_INLINE void store(Number* to, Octet from) {
    static_assert(sizeof(Octet) == 8 * sizeof(Number));
    std::memcpy(to, &from, sizeof from);
}

/// a - b where they are less than 2^31 apart.
VDBPACK_INLINE Float8 difference(Word8 a, std::uint32_t b) {
    return __builtin_convertvector(bitsAs<Int8>(a - b), Float8);
}
VDBPACK_INLINE float difference(std::uint32_t a, std::uint32_t b) {
    return static_cast<float>(static_cast<std::int32_t>(a - b));
}

VDBPACK_INLINE Float8 squareRoot(Float8 v) {
#if defined(__AVX2__)
    return _mm256_sqrt_ps(v);
#else
    for (int l = 0; l < 8; ++l) v[l] = std::sqrt(v[l]);
    return v;
#endif
}

/// `v` where the mask is set, else 0.
VDBPACK_INLINE Float8 where8(Int8 mask, Float8 v) {
    return bitsAs<Float8>(bitsAs<Int8>(v) & mask);
}

VDBPACK_INLINE Float8 larger(Float8 a, Float8 b) {
#if defined(__AVX2__)
    return _mm256_max_ps(a, b);
#else
    for (int l = 0; l < 8; ++l) a[l] = a[l] > b[l] ? a[l] : b[l];
    return a;
#endif
}

VDBPACK_INLINE Float8 smaller(Float8 a, Float8 b) {
#if defined(__AVX2__)
    return _mm256_min_ps(a, b);
#else
    for (int l = 0; l < 8; ++l) a[l] = a[l] < b[l] ? a[l] : b[l];
    return a;
#endif
}

/// One bit a lane, the lowest of lane 0.
VDBPACK_INLINE unsigned bitsOf(Int8 mask) {
#if defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(bitsAs<__m256>(mask)));
#else
    unsigned bits = 0;
    for (int l = 0; l < 8; ++l) bits |= (mask[l] != 0 ? 1u : 0u) << l;
    return bits;
#endif
}

/// For each set of lanes the numbers of those in it, one a byte, the lowest first.
inline constexpr auto kLanesOf = [] {
    std::array<std::uint64_t, 256> lanes{};
    for (unsigned bits = 0; bits < 256; ++bits) {
        unsigned at = 0;
        for (std::uint64_t l = 0; l < 8; ++l)
            if ((bits >> l & 1u) != 0) lanes[bits] |= l << 8 * at++;
    }
    return lanes;
}();

/// Writes the lanes that are set in `bits` one after the other; whole eights are written.
/// @return how many they are.
VDBPACK_INLINE unsigned writeLanes(std::uint32_t* to, Word8 from, unsigned bits) {
#if defined(__AVX2__)
    const __m256i lanes =
        _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kLanesOf[bits])));
    store(to, bitsAs<Word8>(_mm256_permutevar8x32_epi32(bitsAs<__m256i>(from), lanes)));
#else
    std::uint64_t lanes = kLanesOf[bits];
    for (int l = 0; l < 8; ++l, lanes >>= 8) to[l] = from[lanes & 7u];
#endif
    return static_cast<unsigned>(__builtin_popcount(bits));
}

/// The sum in the same order on every machine.
VDBPACK_INLINE float sum(Float8 v) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}
VDBPACK_INLINE float smallest(Float8 v) {
    float least = v[0];
    for (int l = 1; l < 8; ++l) least = v[l] < least ? v[l] : least;
    return least;
}
VDBPACK_INLINE float largest(Float8 v) {
    float most = v[0];
    for (int l = 1; l < 8; ++l) most = v[l] > most ? v[l] : most;
    return most;
}

}  // namespace vdbpack
