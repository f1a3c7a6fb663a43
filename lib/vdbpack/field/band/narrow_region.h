// Private: the parts of a band over small triangles, flat edges and flat vertices, lattice point by
// lattice point.
#pragma once

#include "vdbpack/core/lanes.h"
#include "vdbpack/field/band/band_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace vdbpack {

/// Eight points, relative to a lattice point.
using Lanes3 = std::array<Float8, 3>;

/// A linear function of eight points.
struct Linear3 {
    float x = 0, y = 0, z = 0, at0 = 0;
    Linear3() = default;
    Linear3(const Vec<3>& gradient, double valueAt0)
        : x(static_cast<float>(gradient[0])),
          y(static_cast<float>(gradient[1])),
          z(static_cast<float>(gradient[2])),
          at0(static_cast<float>(valueAt0)) {}
    VDBPACK_INLINE Float8 operator()(const Lanes3& p) const {
        return p[0] * x + p[1] * y + p[2] * z + at0;
    }
};

/// A region that is long along one axis of the lattice and narrow across it: most lattice planes
/// across that axis hold no point of it, and are passed over eight at a time.
///
/// All points of the region are inside its bounds; not all points inside its bounds are of the
/// region.
class NarrowRegion {
public:
    /// The prism over the triangle abc with the unit normal n.
    static NarrowRegion over(const std::array<Vec<3>, 3>& abc, const Vec<3>& n,
                             const BandWidths& widths) {
        NarrowRegion region(n);
        // Gaps reach out of the prism by kFlat of the distance.
        const double w = n[region.w_], gap = 2 * kFlat * widths.larger();
        for (std::size_t i = 0; i < 2; ++i) {
            const double slope = n[region.across_[i]] / w;
            region.bound(i, abc.data(), 3, slope, slope, gap);
        }
        region.extend(abc.data(), 3, w * widths.above, -w * widths.below, gap);
        return region;
    }

    /// The wedge that spans from the edge ab to the unit vectors n0 and n1, which enclose less than
    /// a right angle.
    static NarrowRegion over(const std::array<Vec<3>, 2>& ab, const Vec<3>& n0, const Vec<3>& n1,
                             double reach) {
        NarrowRegion region(n0 + n1);
        const double w0 = n0[region.w_], w1 = n1[region.w_];
        if (!(w0 * w1 > 0)) return {};
        for (std::size_t i = 0; i < 2; ++i) {
            const double s0 = n0[region.across_[i]] / w0, s1 = n1[region.across_[i]] / w1;
            region.boundAhead(i, ab.data(), 2, std::minmax(s0, s1), w0);
        }
        // The vectors between n0 and n1 may be longer along the axis than both.
        region.extend(ab.data(), 2, 0, std::copysign(reach, w0));
        return region;
    }

    /// The cone from `apex` about the unit vector `axis`.
    /// @param cosine  of the angle between its axis and its surface.
    static NarrowRegion over(const Vec<3>& apex, const Vec<3>& axis, double cosine, double reach) {
        NarrowRegion region(axis);
        const double most = std::sqrt(std::max(0.0, 2 - 2 * cosine));  // between unit vectors
        const double w = axis[region.w_];
        if (!(std::abs(w) > 2 * most)) return {};
        for (std::size_t i = 0; i < 2; ++i) {
            const double u = axis[region.across_[i]];
            const auto [low, high] =
                std::minmax({(u - most) / (w - most), (u - most) / (w + most),
                             (u + most) / (w - most), (u + most) / (w + most)});
            region.boundAhead(i, &apex, 1, {low, high}, w);
        }
        region.extend(&apex, 1, 0, std::copysign(reach, w));
        return region;
    }

    /// Whether its bounds are nowhere wider than `most` voxels.
    bool isNarrow(double most) const {
        for (const Bounds& b : bounds_)
            for (const double p : {low_, high_})
                if (!(b.high(p) - b.low(p) < most)) return false;
        return true;
    }

    /// Calls `visit(x, square)` for each lattice point inside the bounds.
    /// @param squares  `TriangleSquares`, `EdgeSquares` or `PointSquares`.
    template <class Squares, class Visit>
    void visit(const Squares& squares, const Visit& visit) const {
        const auto w = static_cast<std::size_t>(w_), u = static_cast<std::size_t>(across_[0]),
                   v = static_cast<std::size_t>(across_[1]);
        for (double first = std::ceil(low_); first <= high_; first += kLanes) {
            const Int8 planes = kPlanes <= static_cast<float>(high_ - first);
            const Window wu = window(bounds_[0], first), wv = window(bounds_[1], first);
            // Of a fine mesh, most regions hold no lattice point.
            const Int8 held = planes & (wu.first <= wu.last) & (wv.first <= wv.last);
            if (noneOf(held)) continue;
            Vec<3> base;
            base.c[w] = first;
            base.c[u] = wu.base;
            base.c[v] = wv.base;
            const auto near = squares.near(base);
            Lanes3 x;
            x[w] = kPlanes;
            for (x[u] = wu.first;; x[u] += 1) {
                const Int8 column = held & (x[u] <= wu.last);
                if (noneOf(column)) break;
                for (x[v] = wv.first;; x[v] += 1) {
                    Int8 point = column & (x[v] <= wv.last);
                    if (noneOf(point)) break;
                    const Float8 square = near(x, point);
                    forEachSet(point, [&](std::size_t lane) {
                        std::array<std::int32_t, 3> at;
                        for (std::size_t i = 0; i < 3; ++i)
                            at[i] = static_cast<std::int32_t>(base.c[i]) +
                                    static_cast<std::int32_t>(x[i][lane]);
                        visit(at, square[lane]);
                    });
                }
            }
        }
    }

private:
    /// Along an axis across, as linear functions of the coordinate p along the region.
    struct Bounds {
        double lowAt0, lowSlope, highAt0, highSlope;
        double low(double p) const { return lowAt0 + p * lowSlope; }
        double high(double p) const { return highAt0 + p * highSlope; }
    };

    /// Nothing is narrow about it.
    NarrowRegion() : bounds_{{{0, 0, kInfinite, 0}, {0, 0, kInfinite, 0}}} {}
    explicit NarrowRegion(const Vec<3>& along) {
        for (int i = 1; i < 3; ++i)
            if (std::abs(along[i]) > std::abs(along[w_])) w_ = i;
        across_ = {(w_ + 1) % 3, (w_ + 2) % 3};
    }

    /// Bounds of the lines from the points, if the lines of the lower bound have one slope and the
    /// lines of the upper another.
    void bound(std::size_t i, const Vec<3>* points, std::size_t count, double lowSlope,
               double highSlope, double slack = 0) {
        double low = kInfinite, high = -kInfinite;
        for (std::size_t k = 0; k < count; ++k) {
            const double x = points[k][across_[i]], p = points[k][w_];
            low = std::min(low, x - p * lowSlope);
            high = std::max(high, x - p * highSlope);
        }
        bounds_[i] = {low - kSlack - slack, lowSlope, high + kSlack + slack, highSlope};
    }
    /// Bounds of the half-lines from the points with slopes in a range.
    /// @param direction  its sign is the sign of the half-lines along the region.
    void boundAhead(std::size_t i, const Vec<3>* points, std::size_t count,
                    const std::pair<double, double>& slopes, double direction) {
        if (direction > 0)
            bound(i, points, count, slopes.first, slopes.second);
        else
            bound(i, points, count, slopes.second, slopes.first);
    }
    void extend(const Vec<3>* points, std::size_t count, double one, double other,
                double slack = 0) {
        low_ = kInfinite;
        high_ = -kInfinite;
        for (std::size_t k = 0; k < count; ++k) {
            low_ = std::min(low_, points[k][w_]);
            high_ = std::max(high_, points[k][w_]);
        }
        low_ += std::min(one, other) - kSlack - slack;
        high_ += std::max(one, other) + kSlack + slack;
    }

    /// Bounds in eight planes, relative to a lattice coordinate, so that single precision suffices.
    struct Window {
        double base;
        Float8 first, last;  ///< the first lattice point in each plane, and the upper bound
    };
    static Window window(const Bounds& b, double firstPlane) {
        const double low = b.low(firstPlane), base = std::floor(low);
        const Float8 lows =
            kPlanes * static_cast<float>(b.lowSlope) + static_cast<float>(low - base - kLaneSlack);
        return {base, -floorOf(-lows),
                kPlanes * static_cast<float>(b.highSlope) +
                    static_cast<float>(b.high(firstPlane) - base + kLaneSlack)};
    }
    static Float8 floorOf(Float8 v) {
        const Float8 whole = __builtin_convertvector(__builtin_convertvector(v, Int8), Float8);
        return choose(whole > v, whole - 1.0f, whole);
    }

    /// Eight planes, relative to the first.
    static constexpr Float8 kPlanes{0, 1, 2, 3, 4, 5, 6, 7};
    static constexpr double kInfinite = std::numeric_limits<double>::infinity();
    /// Added on all sides, so that rounding leaves out no point; voxels.
    static constexpr double kSlack = 1e-7;
    /// More than the rounding in a window.
    static constexpr double kLaneSlack = 2e-6;

    int w_ = 0;                    ///< the axis along the region
    std::array<int, 2> across_{};  ///< the others
    double low_ = 0, high_ = 0;    ///< extent along w
    std::array<Bounds, 2> bounds_;
};

/// The most that a linear function with this gradient changes within 1 along each axis; no less
/// than its length.
inline double supportOf(const Vec<3>& gradient) {
    return std::abs(gradient[0]) + std::abs(gradient[1]) + std::abs(gradient[2]);
}

/// The side of a plane that `inward` points to, with what rounding may take from it, so that no
/// point between two regions is left out.
/// @param base  that of the points, relative to a point of the plane.
inline Linear3 inwardSide(const Vec<3>& inward, const Vec<3>& base) {
    constexpr double kRounding = 4e-6;  // voxels
    return Linear3(inward, dot(base, inward) + kRounding * supportOf(inward));
}

/// Squared distance to the plane of a triangle, of points that project into it.
class TriangleSquares {
public:
    TriangleSquares(const std::array<Vec<3>, 3>& abc, const Vec<3>& n, const BandWidths& widths)
        : n_(n), abc_(abc), widths_(widths) {}

    class Near {
    public:
        /// @param x  relative to the base. @param points  those that do not project into the
        ///        triangle (or a gap of a flat face), or lie beyond the band, are taken out.
        VDBPACK_INLINE Float8 operator()(const Lanes3& x, Int8& points) const {
            const Float8 d = plane_(x);
            points &= (d <= widths_.above) & (d >= -widths_.below);
            for (std::size_t k = 0; k < 3; ++k)
                points &= sides_[k](x) + absolute(d) * gaps_[k] >= 0.0f;
            return d * d;
        }

    private:
        friend class TriangleSquares;
        Linear3 plane_;
        std::array<Linear3, 3> sides_;
        std::array<float, 3> gaps_;  ///< how far outside of each side a gap may reach, by distance
        BandWidths widths_;
    };
    Near near(const Vec<3>& base) const {
        Near near;
        near.plane_ = Linear3(n_, dot(base - abc_[0], n_));
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec<3> inward = cross(n_, abc_[(k + 1) % 3] - abc_[k]);
            near.sides_[k] = inwardSide(inward, base - abc_[k]);
            near.gaps_[k] = static_cast<float>(kFlat * supportOf(inward));
        }
        near.widths_ = widths_;
        return near;
    }

private:
    Vec<3> n_;
    std::array<Vec<3>, 3> abc_;
    BandWidths widths_;
};

/// Squared distance to an edge of positive length, of points in its wedge.
class EdgeSquares {
public:
    EdgeSquares(const std::array<Vec<3>, 2>& ab, const BandEdge& edge)
        : a_(ab[0]), along_(ab[1] - ab[0]), edge_(edge) {}

    class Near {
    public:
        /// As in TriangleSquares, for points that lie outside the wedge.
        VDBPACK_INLINE Float8 operator()(const Lanes3& x, Int8& points) const {
            for (const Linear3& side : sides_) points &= side(x) >= 0.0f;
            const Float8 t = smaller(larger(share_(x), 0.0f), 1.0f);
            Float8 square{};
            for (std::size_t i = 0; i < 3; ++i) {
                const Float8 d = x[i] + offset_[i] - t * along_[i];
                square += d * d;
            }
            return square;
        }

    private:
        friend class EdgeSquares;
        std::array<Linear3, 2> sides_;
        Linear3 share_;
        std::array<float, 3> offset_, along_;
    };
    Near near(const Vec<3>& base) const {
        Near near;
        const Vec<3> offset = base - a_, share = along_ * (1 / squaredLength(along_));
        near.sides_ = {inwardSide(edge_.inward0(along_), offset),
                       inwardSide(edge_.inward1(along_), offset)};
        near.share_ = Linear3(share, dot(offset, share));
        for (std::size_t i = 0; i < 3; ++i) {
            near.offset_[i] = static_cast<float>(offset.c[i]);
            near.along_[i] = static_cast<float>(along_.c[i]);
        }
        return near;
    }

private:
    Vec<3> a_, along_;
    const BandEdge& edge_;
};

/// Squared distance to a point.
class PointSquares {
public:
    explicit PointSquares(const Vec<3>& point) : point_(point) {}

    struct Near {
        std::array<float, 3> offset;
        VDBPACK_INLINE Float8 operator()(const Lanes3& x, Int8&) const {
            Float8 square{};
            for (std::size_t i = 0; i < 3; ++i) square += (x[i] + offset[i]) * (x[i] + offset[i]);
            return square;
        }
    };
    Near near(const Vec<3>& base) const {
        const Vec<3> offset = base - point_;
        return {{static_cast<float>(offset[0]), static_cast<float>(offset[1]),
                 static_cast<float>(offset[2])}};
    }

private:
    Vec<3> point_;
};

}  // namespace vdbpack
