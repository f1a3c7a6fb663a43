// Private to densify: spheres in integer positions, one by one and eight at a time.
#pragma once

#include "vdbpack/core/lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace vdbpack {

/// A sphere as the relaxation sees it, in units of the quantum; 2D: `z` is 0.
///
/// Positions are the low 32 bits of whole positions: differences are taken modulo 2^32, so that
/// those of near spheres are right however large the domain is.
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

/// The whole position of a body that was at `home` when its low bits were last taken.
inline Home whereIs(const Home& home, const Body& body) {
    const auto moved = [](std::int64_t was, std::uint32_t is) {
        return was + static_cast<std::int32_t>(is - lowBits(was));
    };
    return {moved(home[0], body.x), moved(home[1], body.y), moved(home[2], body.z)};
}

/// Whether the difference of low bits is the difference of two positions.
inline bool isNear(const Home& a, const Home& b) {
    for (std::size_t d = 0; d < 3; ++d)
        if (a[d] - b[d] > (std::int64_t(1) << 30) || b[d] - a[d] > (std::int64_t(1) << 30))
            return false;
    return true;
}

using Word4 [[gnu::vector_size(16)]] = std::uint32_t;

/// Eight bodies, component by component.
struct Bodies8 {
    Word8 x, y, z;
    Float8 radius;
};

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

/// Writes bodies to `to[ids[0]]` to `to[ids[7]]`.
VDBPACK_INLINE void scatter(Body* to, const std::uint32_t* ids, const Bodies8& b) {
    const Word8 r = bitsAs<Word8>(b.radius);
    const Word8 xy04 = __builtin_shufflevector(b.x, b.y, 0, 8, 1, 9, 4, 12, 5, 13);
    const Word8 xy26 = __builtin_shufflevector(b.x, b.y, 2, 10, 3, 11, 6, 14, 7, 15);
    const Word8 zr04 = __builtin_shufflevector(b.z, r, 0, 8, 1, 9, 4, 12, 5, 13);
    const Word8 zr26 = __builtin_shufflevector(b.z, r, 2, 10, 3, 11, 6, 14, 7, 15);
    const Word8 rows[4] = {__builtin_shufflevector(xy04, zr04, 0, 1, 8, 9, 4, 5, 12, 13),
                           __builtin_shufflevector(xy04, zr04, 2, 3, 10, 11, 6, 7, 14, 15),
                           __builtin_shufflevector(xy26, zr26, 0, 1, 8, 9, 4, 5, 12, 13),
                           __builtin_shufflevector(xy26, zr26, 2, 3, 10, 11, 6, 7, 14, 15)};
    for (int l = 0; l < 4; ++l) {
        const Word4 low = __builtin_shufflevector(rows[l], rows[l], 0, 1, 2, 3);
        const Word4 high = __builtin_shufflevector(rows[l], rows[l], 4, 5, 6, 7);
        std::memcpy(static_cast<void*>(to + ids[l]), &low, sizeof low);
        std::memcpy(static_cast<void*>(to + ids[l + 4]), &high, sizeof high);
    }
}

/// a - b, for positions less than 2^31 apart.
VDBPACK_INLINE Float8 difference(Word8 a, Word8 b) {
    return __builtin_convertvector(bitsAs<Int8>(a - b), Float8);
}
VDBPACK_INLINE Float8 difference(Word8 a, std::uint32_t b) {
    return __builtin_convertvector(bitsAs<Int8>(a - b), Float8);
}
VDBPACK_INLINE float difference(std::uint32_t a, std::uint32_t b) {
    return static_cast<float>(static_cast<std::int32_t>(a - b));
}

/// Whether bodies are farther from where they were `listed` than the radius there.
VDBPACK_INLINE bool isBeyond(const Body& listed, const Body& body) {
    const float x = difference(body.x, listed.x), y = difference(body.y, listed.y),
                z = difference(body.z, listed.z);
    return x * x + y * y + z * z > listed.radius * std::abs(listed.radius);
}
VDBPACK_INLINE Int8 areBeyond(const Bodies8& listed, const Bodies8& body) {
    const Float8 x = difference(body.x, listed.x), y = difference(body.y, listed.y),
                 z = difference(body.z, listed.z);
    return x * x + y * y + z * z > listed.radius * absolute(listed.radius);
}

}  // namespace vdbpack
