// Private to verify: distances to wall pieces, of one point or of four at a time.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/verify/wall_shape.h"

#include <array>
#include <cmath>
#include <cstddef>
#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace vdbpack::pieces {

/// Four numbers: arithmetic, comparisons and `?:` go lane by lane, each rounded as IEEE 754 asks.
using Four [[gnu::vector_size(32)]] = double;
using Lanes = std::array<double, 4>;
static_assert(sizeof(Four) == sizeof(Lanes));

inline bool any(decltype(Four{} < Four{}) mask) {
#if defined(__AVX__)
    return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask)) != 0;
#else
    return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
#endif
}

// One number or four: the same formula, the same bits.

template <class Number, int Dim>
using Coordinates = std::array<Number, static_cast<std::size_t>(Dim)>;

template <class Number>
Number smaller(Number a, Number b) {
    return a < b ? a : b;
}
template <class Number>
Number larger(Number a, Number b) {
    return a > b ? a : b;
}
inline Four squareRoot(Four v) {
#if defined(__AVX__)
    return reinterpret_cast<Four>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(v)));
#else
    for (std::size_t k = 0; k < 4; ++k) v[k] = std::sqrt(v[k]);
    return v;
#endif
}

template <class Number, int Dim>
Coordinates<Number, Dim> relative(const Coordinates<Number, Dim>& x, const Vec<Dim>& to) {
    Coordinates<Number, Dim> d = x;
    for (std::size_t i = 0; i < d.size(); ++i) d[i] -= to.c[i];
    return d;
}

template <class Number, int Dim>
Number product(const Coordinates<Number, Dim>& a, const Vec<Dim>& b) {
    Number sum = a[0] * b.c[0];
    for (std::size_t i = 1; i < a.size(); ++i) sum += a[i] * b.c[i];
    return sum;
}

/// Squared distance to the segment from 0 to `edge`, mm².
template <class Number, int Dim>
Number squaredDistanceToEdge(Coordinates<Number, Dim> x, const Vec<Dim>& edge) {
    const double square = squaredLength(edge);
    const double inverse = square > 1e-290 ? 1 / square : 0;
    const Number zero{},
        t = smaller(larger(product<Number, Dim>(x, edge) * inverse, zero), zero + 1);
    Number sum{};
    for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] -= t * edge.c[i];
        sum += x[i] * x[i];
    }
    return sum;
}

inline bool anyLess(double a, double b) {
    return a < b;
}
inline bool anyLess(Four a, Four b) {
    return any(a < b);
}

/// Squared distance to a piece, mm²; anything not below `bound` where that is not below.
template <class Number>
Number squaredDistanceTo(const WallPiece<2>& piece, const Coordinates<Number, 2>& x,
                         Number /*bound*/) {
    return squaredDistanceToEdge<Number, 2>(relative<Number, 2>(x, piece[0]), piece[1] - piece[0]);
}

template <class Number>
Number squaredDistanceTo(const WallPiece<3>& piece, const Coordinates<Number, 3>& x, Number bound) {
    const Vec<3> ab = piece[1] - piece[0], ac = piece[2] - piece[0];
    const auto ap = relative<Number, 3>(x, piece[0]);
    const Vec<3> n = cross(ab, ac);
    const double nn = squaredLength(n);
    // The normal of a thinner sliver is noise, but then its edges are near all of it.
    const bool flat = nn > 1e-16 * squaredLength(ab) * squaredLength(ac);
    Number toPlane{};
    if (flat) {
        const Number h = product<Number, 3>(ap, n);
        toPlane = h * h * (1 / nn);
        if (!anyLess(toPlane, bound)) return toPlane;
    }
    const Number toEdges = smaller(
        smaller(squaredDistanceToEdge<Number, 3>(ap, ab), squaredDistanceToEdge<Number, 3>(ap, ac)),
        squaredDistanceToEdge<Number, 3>(relative<Number, 3>(x, piece[1]), ac - ab));
    if (!flat) return toEdges;
    const Number u = product<Number, 3>(ap, cross(n, ab)), v = product<Number, 3>(ap, cross(ac, n));
    return ((u >= 0.0) & (v >= 0.0) & (u + v <= nn)) ? toPlane : toEdges;
}

}  // namespace vdbpack::pieces
