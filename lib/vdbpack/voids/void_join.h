// The voids nearest to a point, and roundings where struts remain between them.
#pragma once

#include "vdbpack/core/lanes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace vdbpack {

/// The voids that are nearest to a point (one number) or to eight: three in space, two in a plane.
template <int Dim, class Number, class Word>
class NearestVoids {
public:
    NearestVoids() {
        for (Number& d : distance_) d = Number{} + std::numeric_limits<float>::max();
    }

    VDBPACK_INLINE void add(Number distance, Word id) {
        for (std::size_t k = 0; k < Dim; ++k) {
            const auto nearer = distance < distance_[k];
            const Number d = nearer ? distance_[k] : distance;
            const Word i = nearer ? ids_[k] : id;
            distance_[k] = nearer ? distance : distance_[k];
            ids_[k] = nearer ? id : ids_[k];
            distance = d;
            id = i;
        }
    }

    VDBPACK_INLINE Number nearest() const { return distance_[0]; }
    /// The distance to the last of them.
    VDBPACK_INLINE Number farthest() const { return distance_[Dim - 1]; }

    /// Square of the distance to the line where all of them are equally near: exact for planes at
    /// equal angles about it, as those of a foam are.
    VDBPACK_INLINE Number squareFromLine() const {
        Number mean{}, sum{};
        for (const Number& d : distance_) mean += d * (1.0f / Dim);
        for (const Number& d : distance_) sum += (d - mean) * (d - mean);
        return sum * (Dim == 3 ? 2.0f / 3 : 0.5f);
    }

    /// From 0 to 1, the same along all of that line.
    VDBPACK_INLINE Word chance() const {
        Word sum{};
        for (const Word& id : ids_) sum += mixed(id);
        return mixed(sum) >> 8;
    }
    /// `chance` of which a share of the lines lies below.
    static std::uint32_t below(double share) {
        return static_cast<std::uint32_t>(std::clamp(share, 0.0, 1.0) * (1u << 24));
    }

private:
    /// The finalizer of MurmurHash3 (Appleby 2011): a bijection whose bits all depend on all.
    VDBPACK_INLINE static Word mixed(Word x) {
        x ^= x >> 16;
        x *= 0x85ebca6bu;
        x ^= x >> 13;
        x *= 0xc2b2ae35u;
        x ^= x >> 16;
        return x;
    }

    std::array<Number, Dim> distance_;
    std::array<Word, Dim> ids_{};
};

/// The larger of both, rounded where they differ by less than `width`.
template <class Number>
VDBPACK_INLINE Number roundedMax(Number a, Number b, float width) {
    const Number most = a > b ? a : b;
    if (!(width > 0)) return most;
    const Number apart = a > b ? a - b : b - a;
    const Number near = width - apart;
    return most + (near > 0.0f ? near * near * (0.25f / width) : Number{});
}

}  // namespace vdbpack
