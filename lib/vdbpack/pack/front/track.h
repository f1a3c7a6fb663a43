// The path of a sphere that grows while it touches a pivot and other bodies.
#pragma once

#include "vdbpack/core/lanes.h"
#include "vdbpack/pack/front/cap.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

/// The path of the center of a sphere that grows from radius `start` on while it touches the pivot
/// and Dim - 1 more bodies:
///     x(t) = alpha(t) a + beta(t) b + side sqrt(extent(t)) w,  t = radius - start,
/// with a, b the directions of their caps and w normal to them; alpha and beta are linear in t,
/// extent is quadratic. In 2D there is no b.
template <class T, int Dim>
struct Track {
    std::array<T, Dim> a, b, w;
    T alpha0, alpha1, beta0, beta1;
    T extent0, extent1, extent2;
    T side;

    /// For caps whose directions are not parallel; where `extent0` is negative the sphere cannot
    /// touch all bodies at the start.
    /// @param rolling  pivot radius + start.
    /// @param caps     of the Dim - 1 bodies.
    /// @param sign     +1 or -1: the side of the bodies on which the sphere lies.
    template <class Scalar>
    void set(Scalar rolling, Scalar start, const std::array<Cap<T, Dim>, Dim - 1>& caps,
             Scalar sign) {
        const Scalar two = 2;
        const Cap<T, Dim>& first = caps[0];
        a = first.to;
        const T ca = first.level + start * first.slope, ma = first.slope;
        T aa{};
        for (std::size_t d = 0; d < Dim; ++d) aa += a[d] * a[d];
        T area;
        if constexpr (Dim == 3) {
            const Cap<T, Dim>& second = caps[1];
            b = second.to;
            const T cb = second.level + start * second.slope, mb = second.slope;
            const T bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
            const T ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            area = aa * bb - ab * ab;
            w = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
            const T inverse = Scalar(1) / area;
            alpha0 = (ca * bb - cb * ab) * inverse;
            beta0 = (cb * aa - ca * ab) * inverse;
            alpha1 = (ma * bb - mb * ab) * inverse;
            beta1 = (mb * aa - ma * ab) * inverse;
            extent0 = rolling * rolling * area - (ca * ca * bb - two * ca * cb * ab + cb * cb * aa);
            extent1 =
                two * (rolling * area - (ca * ma * bb - (ca * mb + cb * ma) * ab + cb * mb * aa));
            extent2 = area - (ma * ma * bb - two * ma * mb * ab + mb * mb * aa);
            side = sign * inverse;
        } else {
            b.fill(T{});
            area = aa;
            w = {-a[1], a[0]};
            alpha0 = ca / aa, alpha1 = ma / aa;
            beta0 = beta1 = T{};
            extent0 = rolling * rolling * area - ca * ca;
            extent1 = two * (rolling * area - ca * ma);
            extent2 = area - ma * ma;
            side = sign / area;
        }
    }

    /// As `set`, with any caps. @return false if there is no such path.
    bool make(T rolling, T start, const std::array<Cap<T, Dim>, Dim - 1>& caps, T sign) {
        if constexpr (Dim == 3) {
            const auto &p = caps[0].to, &q = caps[1].to;
            const T pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            const T qq = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
            const T pq = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
            if (!(pp * qq - pq * pq > T(1e-6) * pp * qq)) return false;
        }
        set(rolling, start, caps, sign);
        return extent0 >= 0;
    }

    /// Of a sphere that touches the pivot alone, in unit direction `n`.
    void makeLoose(T rolling, const std::array<T, Dim>& n) {
        a = b = {};
        w = n;
        alpha0 = alpha1 = beta0 = beta1 = 0;
        extent0 = rolling * rolling;
        extent1 = 2 * rolling;
        extent2 = 1;
        side = 1;
    }

    /// The middle between the two centers (of either side) after growing by `t`.
    /// @return the extent there.
    template <class Scalar>
    T middle(Scalar t, std::array<T, Dim>& x) const {
        const T alpha = alpha0 + t * alpha1, beta = beta0 + t * beta1;
        for (std::size_t d = 0; d < Dim; ++d) x[d] = alpha * a[d] + beta * b[d];
        return extent0 + t * (extent1 + t * extent2);
    }

    /// The center after growing by `t`. @return false if there is none.
    bool at(T t, std::array<T, Dim>& x) const {
        const T extent = middle(t, x);
        if (!(extent >= 0)) return false;
        const T out = side * std::sqrt(extent);
        for (std::size_t d = 0; d < Dim; ++d) x[d] += out * w[d];
        return true;
    }

    /// The largest growth up to `most` for which the sphere can touch all its bodies.
    T end(T most) const {
        const T disc = extent1 * extent1 - 4 * extent2 * extent0;
        if (!(disc >= 0)) return most;
        const T q = T(-0.5) * (extent1 + std::copysign(std::sqrt(disc), extent1));
        // Both roots; extent0 >= 0, so the first positive one ends the path.
        for (const T root : {q / extent2, extent0 / q})
            if (root > 0 && root < most) most = root;
        return most;
    }
};

template <class N>
VDBPACK_INLINE N along(const std::array<float, 3>& a, const std::array<N, 3>& x) {
    return a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
}
template <class N>
VDBPACK_INLINE N along(const std::array<float, 2>& a, const std::array<N, 2>& x) {
    return a[0] * x[0] + a[1] * x[1];
}

/// The growth t in [0, most] at which a sphere on `track` first enters a cap; `most` if it does
/// not. One cap (N = float) or eight (N = Float8).
/// @param level      of the cap at the start of the track.
/// @param tolerance  growth below 0 that counts as a hit, mm.
template <class N, int Dim>
VDBPACK_INLINE N firstHit(const Track<float, Dim>& track, const std::array<N, Dim>& to,
                          const N& level, const N& slope, float tolerance, float most) {
    // Off the body while u(t) - g sqrt(extent(t)) >= 0 with u linear: a hit is a root of
    // u² - g² extent where u and g have one sign; of the two roots, the slopes tell which one
    // leads into the body. Bodies that the track rests on have u = g = 0, within rounding.
    const N alongA = along(track.a, to);
    N u0 = level - track.alpha0 * alongA, u1 = slope - track.alpha1 * alongA;
    if constexpr (Dim == 3) {
        const N alongB = along(track.b, to);
        u0 -= track.beta0 * alongB;
        u1 -= track.beta1 * alongB;
    }
    const N g = track.side * along(track.w, to);
    const N gg = g * g;
    const N qa = u1 * u1 - gg * track.extent2;
    const N qb = 2.0f * u0 * u1 - gg * track.extent1;
    const N qc = u0 * u0 - gg * track.extent0;
    const N disc = qb * qb - 4.0f * qa * qc;
    const N q = -0.5f * (qb + withSign(squareRoot(larger(disc, 0.0f)), qb));
    const auto same = qb * g > 0.0f;
    const N t = choose(same, q, qc) / choose(same, qa, q);
    const auto found = (disc >= 0.0f) & (t > -tolerance) & ((u0 + u1 * t) * g >= 0.0f) & (t < most);
    return larger(choose(found, t, most), 0.0f);
}

}  // namespace vdbpack
