#include "vdbpack/voids/tile.h"

#include "vdbpack/core/lanes.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

static_assert(kTileSide == static_cast<int>(kLanes), "a row of a tile is one group of lanes");

/// Rounds of `ellipseDistance`: what is left is below 1e-3 of the shorter half-axis up to ratios of
/// 10.
constexpr int kRounds = 3;

/// Distance of (x, y) in the first quadrant to the ellipse with half-axes a and b along them, as
/// Ellipsoid::signedDistance finds it; (tx, ty) is the direction to begin with.
[[gnu::always_inline]] inline Lanes ellipseDistance(float a, float b, const Lanes& x,
                                                    const Lanes& y) {
    const float tiny = 1e-12f * a * a;
    const float ea = (a * a - b * b) / a, eb = (b * b - a * a) / b;
    Lanes tx = 0.70710678f, ty = 0.70710678f;
    for (int round = 0; round < kRounds; ++round) {
        const Lanes ex = ea * tx * tx * tx, ey = eb * ty * ty * ty;
        const Lanes rx = a * tx - ex, ry = b * ty - ey;
        const Lanes qx = x - ex, qy = y - ey;
        const Lanes q2 = qx * qx + qy * qy;
        const Lanes ratio = stdx::sqrt((rx * rx + ry * ry) / choose(q2 > tiny, q2, Lanes(tiny)));
        tx = (qx * ratio + ex) * (1 / a);
        ty = (qy * ratio + ey) * (1 / b);
        tx = choose(tx > 0.0f, choose(tx < 1.0f, tx, Lanes(1.0f)), Lanes(0.0f));
        ty = choose(ty > 0.0f, choose(ty < 1.0f, ty, Lanes(1.0f)), Lanes(0.0f));
        const Lanes square = tx * tx + ty * ty;
        // The middle of a ball: every foot is as near.
        const auto lost = square < 1e-12f;
        const Lanes inverse = 1.0f / stdx::sqrt(choose(lost, Lanes(1.0f), square));
        tx = choose(lost, Lanes(a < b ? 1.0f : 0.0f), tx * inverse);
        ty = choose(lost, Lanes(a < b ? 0.0f : 1.0f), ty * inverse);
    }
    const Lanes dx = a * tx - x, dy = b * ty - y;
    return stdx::sqrt(dx * dx + dy * dy);
}

const Lanes& ramp() {
    static const Lanes lanes([](auto i) { return static_cast<float>(static_cast<int>(i)); });
    return lanes;
}

}  // namespace

template <int Dim>
Tile<Dim>::Tile(const Vec<Dim>& firstCenter, double voxelSize, double inside, double outside)
    : first_(firstCenter),
      voxelSize_(voxelSize),
      inside_(static_cast<float>(inside)),
      outside_(static_cast<float>(outside)) {
    values_.fill(outside_);
}

template <int Dim>
void Tile<Dim>::stamp(const Ellipsoid<Dim>& ellipsoid) {
    const auto a = static_cast<float>(ellipsoid.a), b = static_cast<float>(ellipsoid.b);
    const float shorter = std::min(a, b), longer = std::max(a, b);
    const float inverseA = 1 / a, inverseB = 1 / b;
    const auto h = static_cast<float>(voxelSize_);
    // From the void's center, so that floats suffice wherever the bone lies.
    const Vec<Dim> first = first_ - ellipsoid.center;
    std::array<float, Dim> start, axis;
    for (int d = 0; d < Dim; ++d) {
        start[static_cast<std::size_t>(d)] = static_cast<float>(first[d]);
        axis[static_cast<std::size_t>(d)] = static_cast<float>(ellipsoid.axis[d]);
    }
    const Lanes last = start[Dim - 1] + ramp() * h;
    const Lanes lastAlong = last * axis[Dim - 1];
    for (std::size_t row = 0; row < kTileVoxels<Dim> / kLanes; ++row) {
        std::array<float, Dim> at = start;
        if constexpr (Dim == 3) {
            at[0] += static_cast<float>(row / 8) * h;
            at[1] += static_cast<float>(row % 8) * h;
        } else {
            at[0] += static_cast<float>(row) * h;
        }
        float rowAlong = 0;
        for (std::size_t d = 0; d + 1 < Dim; ++d) rowAlong += at[d] * axis[d];
        const Lanes along = lastAlong + rowAlong;
        Lanes across2 = last - along * axis[Dim - 1];
        across2 *= across2;
        for (std::size_t d = 0; d + 1 < Dim; ++d) {
            const Lanes part = at[d] - along * axis[d];
            across2 += part * part;
        }
        // The point lies on the ellipsoid with half-axes f a and f b.
        const Lanes u = along * inverseA;
        const Lanes f = stdx::sqrt(u * u + across2 * (inverseB * inverseB));
        const Lanes outer = (f - 1.0f) * shorter;
        const Lanes inner =
            choose((1.0f - f) * longer < shorter, (f - 1.0f) * longer, Lanes(-shorter));
        const auto within = f < 1.0f;
        Lanes value = load(&values_[row * kLanes]);
        const auto nearer = choose(within, inner, outer) < value;
        if (none_of(nearer)) continue;
        const Lanes distance = ellipseDistance(a, b, stdx::fabs(along), stdx::sqrt(across2));
        Lanes signedDistance = choose(within, -distance, distance);
        signedDistance = choose(signedDistance < -inside_, Lanes(-inside_), signedDistance);
        value = choose(signedDistance < value, signedDistance, value);
        value.copy_to(&values_[row * kLanes], stdx::element_aligned);
    }
}

template <int Dim>
void Tile<Dim>::fillInside() {
    values_.fill(-inside_);
}

template <int Dim>
bool Tile<Dim>::isInside() const {
    return std::all_of(values_.begin(), values_.end(), [&](float v) { return v <= -inside_; });
}

template <int Dim>
bool Tile<Dim>::isOutside() const {
    return std::all_of(values_.begin(), values_.end(), [&](float v) { return v >= outside_; });
}

template <int Dim>
Vec<Dim> Tile<Dim>::centerOf(std::size_t voxel) const {
    Vec<Dim> x = first_;
    for (int d = Dim - 1; d >= 0; --d) {
        x[d] += static_cast<double>(voxel % kTileSide) * voxelSize_;
        voxel /= kTileSide;
    }
    return x;
}

template <int Dim>
VoidAtTile<Dim> boundsAt(const Ellipsoid<Dim>& e, const Vec<Dim>& middle, double radius) {
    const Vec<Dim> to = middle - e.center;
    const double along = dot(to, e.axis);
    const double far = length(to);
    const double across = std::max(0.0, far * far - along * along);
    const double f = std::sqrt(along * along / (e.a * e.a) + across / (e.b * e.b));
    const double shorter = std::min(e.a, e.b), longer = std::max(e.a, e.b);
    VoidAtTile<Dim> bounds;
    bounds.lower = (f > 1 ? (f - 1) * shorter : -std::min(shorter, (1 - f) * longer)) - radius;
    bounds.upper = (f > 1 ? far * (1 - 1 / f) : (f - 1) * shorter) + radius;
    return bounds;
}

template class Tile<2>;
template class Tile<3>;
template VoidAtTile<2> boundsAt(const Ellipsoid<2>&, const Vec<2>&, double);
template VoidAtTile<3> boundsAt(const Ellipsoid<3>&, const Vec<3>&, double);

}  // namespace vdbpack
