// Private: the lattice points over a small triangle, one by one.
#pragma once

#include "vdbpack/field/band/band_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

/// The prism over a triangle, walked plane by plane of the lattice across the axis that its normal
/// is nearest to: every plane cuts the same triangle out of it, shifted along the normal.
///
/// For triangles of about a voxel, of whose prisms most planes hold no point at all.
class PrismPoints {
public:
    /// @param n  unit normal of the triangle abc.
    PrismPoints(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& n,
                const BandWidths& widths)
        : n_(n), widths_(widths) {
        for (int i = 1; i < 3; ++i)
            if (std::abs(n[i]) > std::abs(n[w_])) w_ = i;
        u_ = (w_ + 1) % 3;
        v_ = (w_ + 2) % 3;
        // Relative to a point of the lattice nearby, so that no digits are lost far from zero.
        for (int i = 0; i < 3; ++i) base_[i] = std::floor(a[i]);
        const std::array<Vec<3>, 3> corners{a - base_, b - base_, c - base_};
        a_ = corners[0];
        slopeU_ = n[u_] / n[w_];
        slopeV_ = n[v_] / n[w_];
        low_ = high_ = a_[w_];
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec<3>& x = corners[k];
            cut_[k] = {x[u_] - x[w_] * slopeU_, x[v_] - x[w_] * slopeV_};
            low_ = std::min(low_, x[w_]);
            high_ = std::max(high_, x[w_]);
        }
        for (std::size_t i = 0; i < 2; ++i) {
            lo_[i] = std::min({cut_[0][i], cut_[1][i], cut_[2][i]}) - kSlack;
            hi_[i] = std::max({cut_[0][i], cut_[1][i], cut_[2][i]}) + kSlack;
        }
        const double up = n[w_] * widths.above, down = -n[w_] * widths.below;
        low_ += std::min(up, down);
        high_ += std::max(up, down);
    }

    /// Whether the cut is at most `most` voxels wide along both axes.
    bool isNarrow(double most) const { return hi_[0] - lo_[0] < most && hi_[1] - lo_[1] < most; }

    /// Calls `visit(point, square)` for each lattice point that projects into the triangle, within
    /// the widths, with the square of its distance; voxels.
    template <class Visit>
    void visit(const Visit& visit) const {
        // Of the sides of the cut, the inner one counts as positive.
        const auto side = [&](std::size_t k) {
            const auto &from = cut_[k], &to = cut_[(k + 1) % 3];
            return std::array<double, 2>{to[0] - from[0], to[1] - from[1]};
        };
        const std::array<std::array<double, 2>, 3> sides{side(0), side(1), side(2)};
        const double turn = sides[0][0] * sides[1][1] - sides[0][1] * sides[1][0] < 0 ? -1 : 1;
        for (double p = std::ceil(low_ - kSlack); p <= high_ + kSlack; ++p) {
            const double u = p * slopeU_, v = p * slopeV_;
            const double firstU = std::ceil(lo_[0] + u), firstV = std::ceil(lo_[1] + v);
            for (double i = firstU; i <= hi_[0] + u; ++i)
                for (double j = firstV; j <= hi_[1] + v; ++j) {
                    bool inside = true;
                    for (std::size_t k = 0; k < 3; ++k)
                        inside &= turn * (sides[k][0] * (j - v - cut_[k][1]) -
                                          sides[k][1] * (i - u - cut_[k][0])) >=
                                  -kSlack;
                    if (!inside) continue;
                    Vec<3> x;
                    x[u_] = i;
                    x[v_] = j;
                    x[w_] = p;
                    const double d = dot(x - a_, n_);
                    if (d > widths_.above || d < -widths_.below) continue;
                    visit(x + base_, d * d);
                }
        }
    }

private:
    /// Added to the sides, so that rounding leaves out no point between two triangles; voxels.
    static constexpr double kSlack = 1e-7;

    Vec<3> n_, base_, a_;
    BandWidths widths_;
    int w_ = 0, u_ = 1, v_ = 2;  ///< the axis nearest to the normal, and the others
    double slopeU_ = 0, slopeV_ = 0;
    double low_ = 0, high_ = 0;                 ///< extent along w
    std::array<std::array<double, 2>, 3> cut_;  ///< corners of the cut by the plane w = 0
    std::array<double, 2> lo_, hi_;             ///< their bounds
};

}  // namespace vdbpack
