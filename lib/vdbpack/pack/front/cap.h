// The region that a neighbor forbids to spheres on a pivot.
#pragma once

#include <array>
#include <cstddef>

namespace vdbpack {

/// Depth inside a cap at which a center still counts as outside, in squared rolling radii: above
/// the rounding of the center, far below what matters. The decision is made in double.
inline constexpr float kSlack = 2e-5f;
/// Growth that counts as none, in rolling radii: a body touched at the start stops it at once.
inline constexpr float kTouching = 1e-5f;

/// The cap of one neighbor (a sphere or a wall) of a pivot, as a bound on the center of a sphere
/// that touches the pivot.
///
/// With x the center relative to the pivot's and r the radius, the sphere is clear of the neighbor
/// where x . to <= level + r * slope, and touches it where both are equal. The bound is linear in
/// x because |x| = pivot radius + r is given; spheres and walls take the same form.
template <class T, int Dim>
struct Cap {
    std::array<T, Dim> to;
    T level, slope;

    /// Of a sphere: `to` is its center relative to the pivot's.
    static Cap ofSphere(const std::array<T, Dim>& to, T pivotRadius, T radius) {
        T square = 0;
        for (std::size_t d = 0; d < Dim; ++d) square += to[d] * to[d];
        return {to, T(0.5) * (square + (pivotRadius - radius) * (pivotRadius + radius)),
                pivotRadius - radius};
    }
    /// Of a wall with unit normal into the domain, `above` which the pivot's center lies.
    static Cap ofWall(std::array<T, Dim> normal, T above) {
        for (auto& n : normal) n = -n;
        return {normal, above, T(-1)};
    }
};

}  // namespace vdbpack
