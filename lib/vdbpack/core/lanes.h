// Eight numbers at a time, in one register where the processor has one that wide.
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

// Vectors of the compiler (GCC, Clang): arithmetic and comparisons go lane by lane, a scalar
// operand applies to all lanes, a comparison is an Int8 of -1 (true) and 0. Every operation is
// rounded as IEEE 754 requires, so that results are the same on any processor.
inline constexpr std::size_t kLanes = 8;
using Float8 [[gnu::vector_size(32)]] = float;
using Int8 [[gnu::vector_size(32)]] = std::int32_t;
using Word8 [[gnu::vector_size(32)]] = std::uint32_t;

#define VDBPACK_INLINE [[gnu::always_inline]] inline

/// `n` rounded up to whole lanes.
inline constexpr std::size_t padded(std::size_t n) {
    return (n + kLanes - 1) / kLanes * kLanes;
}

template <class To, class From>
VDBPACK_INLINE To bitsAs(From from) {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    std::memcpy(&to, &from, sizeof to);
    return to;
}

VDBPACK_INLINE Float8 everyLane(float v) {
    return Float8{v, v, v, v, v, v, v, v};
}
/// Eight numbers in a row; no alignment required.
VDBPACK_INLINE Float8 load(const float* from) {
    Float8 v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
template <class Number, class Octet>
VDBPACK_INLINE void store(Number* to, Octet from) {
    static_assert(sizeof(Octet) == kLanes * sizeof(Number));
    std::memcpy(to, &from, sizeof from);
}

// For one number and for eight, so that a formula can be written once for both.

VDBPACK_INLINE float squareRoot(float v) {
    return std::sqrt(v);
}
VDBPACK_INLINE Float8 squareRoot(Float8 v) {
#if defined(__AVX2__)
    return _mm256_sqrt_ps(v);
#else
    for (std::size_t l = 0; l < kLanes; ++l) v[l] = std::sqrt(v[l]);
    return v;
#endif
}

/// 1 / sqrt(v) of numbers that are not negative (of 0 a large number), within 7e-7 of it, by
/// additions and multiplications alone: the same bits wherever these are rounded as IEEE 754
/// requires. Two Newton steps from the bits of v, the first with Kadlec's constants (2010).
template <class Number, class Bits>
VDBPACK_INLINE Number inverseRootOf(Number v) {
    const Number y = bitsAs<Number>(0x5f1ffff9 - (bitsAs<Bits>(v) >> 1));
    const Number z = 0.703952253f * y * (2.38924456f - v * y * y);
    return z * (1.5f - 0.5f * v * z * z);
}
VDBPACK_INLINE float inverseRoot(float v) {
    return inverseRootOf<float, std::int32_t>(v);
}
VDBPACK_INLINE Float8 inverseRoot(Float8 v) {
    return inverseRootOf<Float8, Int8>(v);
}
/// 1 / v of positive numbers whose square is a normal one, in the same way.
template <class Number>
VDBPACK_INLINE Number inverse(Number v) {
    const Number root = inverseRoot(v);
    return root * root;
}

/// `a` where it is larger, else `b`.
VDBPACK_INLINE float larger(float a, float b) {
    return a > b ? a : b;
}
VDBPACK_INLINE Float8 larger(Float8 a, Float8 b) {
#if defined(__AVX2__)
    return _mm256_max_ps(a, b);
#else
    return a > b ? a : b;
#endif
}
VDBPACK_INLINE Float8 larger(Float8 a, float b) {
    return larger(a, everyLane(b));
}

/// `a` where it is smaller, else `b`.
VDBPACK_INLINE float smaller(float a, float b) {
    return a < b ? a : b;
}
VDBPACK_INLINE Float8 smaller(Float8 a, Float8 b) {
#if defined(__AVX2__)
    return _mm256_min_ps(a, b);
#else
    return a < b ? a : b;
#endif
}
VDBPACK_INLINE Float8 smaller(Float8 a, float b) {
    return smaller(a, everyLane(b));
}

VDBPACK_INLINE Float8 absolute(Float8 v) {
    return bitsAs<Float8>(bitsAs<Int8>(v) & 0x7fffffff);
}

/// The least whole number that is not below `v`, within the range of Int8.
VDBPACK_INLINE Int8 roundedUp(Float8 v) {
    const Int8 cut = __builtin_convertvector(v, Int8);
    return cut - (__builtin_convertvector(cut, Float8) < v);
}

/// |v| with the sign of `sign`.
VDBPACK_INLINE float withSign(float v, float sign) {
    return std::copysign(v, sign);
}
VDBPACK_INLINE Float8 withSign(Float8 v, Float8 sign) {
    return bitsAs<Float8>((bitsAs<Int8>(v) & 0x7fffffff) | (bitsAs<Int8>(sign) & ~0x7fffffff));
}

/// `yes` where the mask is set, else `no`.
VDBPACK_INLINE float choose(bool mask, float yes, float no) {
    return mask ? yes : no;
}
VDBPACK_INLINE Float8 choose(Int8 mask, Float8 yes, Float8 no) {
    return mask ? yes : no;
}
VDBPACK_INLINE Float8 choose(Int8 mask, float yes, Float8 no) {
    return choose(mask, everyLane(yes), no);
}
VDBPACK_INLINE Float8 choose(Int8 mask, Float8 yes, float no) {
    return choose(mask, yes, everyLane(no));
}
/// `v` where the mask is set, else 0.
VDBPACK_INLINE Float8 where8(Int8 mask, Float8 v) {
    return bitsAs<Float8>(bitsAs<Int8>(v) & mask);
}

/// One bit a lane, the lowest of lane 0.
VDBPACK_INLINE unsigned bitsOf(Int8 mask) {
#if defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(bitsAs<__m256>(mask)));
#else
    unsigned bits = 0;
    for (std::size_t l = 0; l < kLanes; ++l) bits |= (mask[l] != 0 ? 1u : 0u) << l;
    return bits;
#endif
}
VDBPACK_INLINE bool noneOf(Int8 mask) {
#if defined(__AVX2__)
    return _mm256_testz_ps(bitsAs<__m256>(mask), bitsAs<__m256>(mask)) != 0;
#else
    return bitsOf(mask) == 0;
#endif
}

/// Calls `visit(lane)` for the lanes that are set, by rising number.
template <class Visit>
VDBPACK_INLINE void forEachSet(Int8 mask, Visit visit) {
    for (unsigned bits = bitsOf(mask); bits != 0; bits &= bits - 1)
        visit(static_cast<std::size_t>(__builtin_ctz(bits)));
}

/// For each set of lanes the numbers of those in it, one a byte, the lowest first.
inline constexpr auto kLanesOf = [] {
    std::array<std::uint64_t, 256> lanes{};
    for (unsigned bits = 0; bits < 256; ++bits) {
        unsigned at = 0;
        for (std::uint64_t l = 0; l < kLanes; ++l)
            if ((bits >> l & 1u) != 0) lanes[bits] |= l << 8 * at++;
    }
    return lanes;
}();

/// Brings the lanes that are set in `bits` to the front, in their order; the others become any of
/// the lanes.
class LanePacking {
public:
    VDBPACK_INLINE explicit LanePacking(unsigned bits)
        : count_(static_cast<unsigned>(__builtin_popcount(bits))) {
#if defined(__AVX2__)
        lanes_ = bitsAs<Int8>(
            _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kLanesOf[bits]))));
#else
        for (std::size_t l = 0; l < kLanes; ++l)
            lanes_[l] = static_cast<std::int32_t>(kLanesOf[bits] >> 8 * l & 7u);
#endif
    }
    template <class Octet>
    VDBPACK_INLINE Octet operator()(Octet from) const {
#if defined(__AVX2__)
        return bitsAs<Octet>(
            _mm256_permutevar8x32_epi32(bitsAs<__m256i>(from), bitsAs<__m256i>(lanes_)));
#else
        Octet to;
        for (std::size_t l = 0; l < kLanes; ++l) to[l] = from[static_cast<std::size_t>(lanes_[l])];
        return to;
#endif
    }
    /// Lanes that are set.
    VDBPACK_INLINE unsigned count() const {
        return count_;
    }

private:
    Int8 lanes_;
    unsigned count_;
};

/// The sum, in the same order on every machine.
VDBPACK_INLINE float sum(Float8 v) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}
VDBPACK_INLINE float smallest(Float8 v) {
    v = smaller(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = smaller(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return smaller(v[0], v[1]);
}
VDBPACK_INLINE float largest(Float8 v) {
    v = larger(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = larger(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return larger(v[0], v[1]);
}

}  // namespace vdbpack
