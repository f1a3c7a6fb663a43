// Private to measure: sums over the directions of contacts.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/measure/contacts.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace vdbpack {

/// Directions of contacts, which are added to `fabric` and `stiffness` dozens at a time: many times
/// as fast as one by one. Sums are of whole numbers, so that their order does not matter.
template <int Dim>
class Directions {
public:
    /// @param to  from one center to the other. @param counts  whether the pair counts in the
    /// fabric. @param deep  as of how many spheres in the stiffness.
    void add(const Vec<Dim>& to, double square, bool counts, int deep, ContactSums& sums) {
        const double inverse = 1 / square;
        std::size_t k = 0;
        for (int p = 0; p < Dim; ++p)
            for (int q = p; q < Dim; ++q) products_[k++][count_] = to[p] * to[q] * inverse;
        once_[count_] = counts ? kFixed : 0;
        deep_[count_] = deep > 0 ? kFixed : 0;
        twice_[count_] = deep > 1;
        if (++count_ == kMost) addTo(sums);
    }
    void addTo(ContactSums& sums) {
        constexpr double kRoots[2] = {1.41421356237309504880, 1};  // of Mandel's notation
        std::size_t s = 0;
        for (std::size_t k = 0; k < kProducts; ++k) {
            sums.fabric[k] += sumOf([&, k](std::size_t i) { return products_[k][i] * once_[i]; },
                                    [](auto) { return 0; });
            for (std::size_t l = k; l < kProducts; ++l) {
                const double root = kRoots[isSquare(k)] * kRoots[isSquare(l)];
                sums.stiffness[s++] += sumOf(
                    [&, k, l, root](std::size_t i) {
                        return products_[k][i] * products_[l][i] * root * deep_[i];
                    },
                    [&](std::size_t i) { return twice_[i]; });
            }
        }
        count_ = 0;
    }

private:
    static constexpr double kFixed = 0x1p31;  ///< of a number from -1 to 1
    static constexpr std::size_t kMost = 64, kProducts = Dim * (Dim + 1) / 2;
    static constexpr bool isSquare(std::size_t k) {
        return k == 0 || k + 1 == kProducts || (Dim == 3 && k == 3);
    }
    /// Of whole numbers that values are rounded to: with 1.5 * 2^52 added, these are in the last
    /// bits.
    /// @param doubled  whether a number counts twice: rounded as it is where it counts once.
    template <class Value, class Doubled>
    std::uint64_t sumOf(const Value& value, const Doubled& doubled) const {
        constexpr double kWhole = 0x1.8p52;
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const double shifted = value(i) + kWhole;
            std::uint64_t bits;
            std::memcpy(&bits, &shifted, sizeof bits);
            sum += (bits - 0x4338000000000000u) << doubled(i);
        }
        return sum;
    }

    std::array<std::array<double, kMost>, kProducts> products_;  ///< n_p n_q for p <= q
    std::array<double, kMost> once_, deep_;                      ///< whether they count, as factors
    std::array<std::uint64_t, kMost> twice_{};                   ///< 1: as two deep spheres
    std::size_t count_ = 0;
};

}  // namespace vdbpack
