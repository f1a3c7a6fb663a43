// Private to tiles: ellipsoids in lanes, and batches of them for the blocks of a tile.
#pragma once

#include "vdbpack/core/lanes.h"
#include "vdbpack/voids/tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace vdbpack {

/// TileBlocks of eight neighboring voxels, which are stamped at once: 2 x 2 x 2, in the plane 2
/// x 4.
template <int Dim>
struct TileBlocks {
    static constexpr std::size_t kCount = kTileVoxels<Dim> / kLanes;
    static_assert(kCount % kLanes == 0);

    TileBlocks() {
        std::array<std::size_t, Dim> sides;
        sides.fill(2);
        if (Dim == 2) sides[Dim - 1] = 4;
        double square = 0;
        for (std::size_t d = 0; d < Dim; ++d) {
            middle[d] = 0.5f * static_cast<float>(sides[d] - 1);
            square += 0.25 * static_cast<double>((sides[d] - 1) * (sides[d] - 1));
        }
        radius = static_cast<float>(std::sqrt(square) * (1 + 1e-6));
        for (std::size_t n = 0; n < kCount; ++n) {
            std::size_t rest = n;
            for (std::size_t d = Dim; d-- > 0;) {
                const std::size_t along = kTileSide / sides[d];
                first[d][n] = static_cast<float>(rest % along * sides[d]);
                rest /= along;
            }
        }
        for (std::size_t l = 0; l < kLanes; ++l) {
            std::size_t rest = l;
            for (std::size_t d = Dim; d-- > 0;) {
                lane[d][l] = static_cast<float>(rest % sides[d]);
                rest /= sides[d];
            }
        }
        for (std::size_t v = 0; v < kTileVoxels<Dim>; ++v) {
            std::size_t at = 0;
            for (std::size_t d = 0; d < Dim; ++d)
                at = at * kTileSide +
                     static_cast<std::size_t>(first[d][v / kLanes] + lane[d][v % kLanes]);
            inLeaf[v] = static_cast<std::uint16_t>(at);
        }
    }

    std::array<std::array<float, kCount>, Dim> first;  ///< the first voxel of each block
    std::array<std::array<float, kLanes>, Dim>
        lane;                       ///< offsets of a block's voxels from its first
    std::array<float, Dim> middle;  ///< offset of a block's middle from its first voxel
    float radius;                   ///< from a block's middle to its voxels
    std::array<std::uint16_t, kTileVoxels<Dim>> inLeaf;  ///< index in an OpenVDB leaf

    static const TileBlocks& get() {
        static const TileBlocks blocks;
        return blocks;
    }
};

/// Iterations of `Stamp::distance` for ellipsoids with a / b from 1 to `kPlainRatio`, for other
/// ellipsoids, and beyond the band. The error is below 1e-5 of the shorter half-axis next to the
/// surface and below 2e-3 elsewhere, up to a ratio of 10.
inline constexpr float kPlainRatio = 3.2f;
inline constexpr int kRounds = 2, kLongRounds = 3, kFarRounds = 6;

/// One ellipsoid, or eight in lanes, as needed to bound the distances to them.
template <int Dim, class T>
struct Form {
    std::array<T, Dim> axis;
    T b, shorter, inverseA, inverseB;

    /// Positions of eight points: `along` the axis, squared distance from it, and `f` such that the
    /// point lies on the ellipsoid with half-axes f a, f b.
    struct Position {
        Float8 along, across2, f;
    };
    [[gnu::always_inline]] Position position(const std::array<Float8, Dim>& x) const {
        Position p{};
        for (std::size_t d = 0; d < Dim; ++d) p.along += x[d] * axis[d];
        for (std::size_t d = 0; d < Dim; ++d) {
            const Float8 part = x[d] - p.along * axis[d];
            p.across2 += part * part;
        }
        const Float8 u = p.along * inverseA;
        p.f = squareRoot(u * u + p.across2 * (inverseB * inverseB));
        return p;
    }

    /// A lower bound of the signed distance d: outside f - 1 <= |grad f| d, since f is convex;
    /// inside, the depth is at most the distance to the surface across the axis.
    [[gnu::always_inline]] Float8 lower(const Position& p) const {
        const Float8 u = p.along * inverseA;
        const Float8 steep = squareRoot(u * u * (inverseA * inverseA) +
                                        p.across2 * (inverseB * inverseB * (inverseB * inverseB)));
        const auto within = p.f < 1.0f;
        const Float8 cut = choose(within, 1.0f - u * u, 0.0f);
        const Float8 out = b * squareRoot(cut) - squareRoot(p.across2);
        return choose(within, -smaller(out, shorter),
                      (p.f - 1.0f) * p.f / choose(within, 1.0f, steep));
    }
};

/// A void for stamping a tile, in single precision: positions are relative to the void's center, so
/// that floats suffice however far the bone is from the origin.
template <int Dim>
struct Tile<Dim>::Stamp {
    using Position = typename Form<Dim, float>::Position;

    Stamp() = default;
    Stamp(const Ellipsoid<Dim>& e, const Vec<Dim>& first)
        : a(static_cast<float>(e.a)),
          b(static_cast<float>(e.b)),
          rounds(a < b || a > kPlainRatio * b ? kLongRounds : kRounds),
          evoluteA((a * a - b * b) / a),
          evoluteB((b * b - a * a) / b),
          id(e.id) {
        for (std::size_t d = 0; d < Dim; ++d) {
            start[d] = static_cast<float>(first.c[d] - e.center.c[d]);
            form.axis[d] = static_cast<float>(e.axis.c[d]);
        }
        form.b = b;
        form.shorter = std::min(a, b);
        form.inverseA = 1 / a;
        form.inverseB = 1 / b;
    }

    /// Distance to the surface by the iteration of Ellipsoid::signedDistance: the circle of
    /// curvature at the last foot point (a tx, b ty) gives the next one.
    /// @param far  lanes that take more iterations; the others do not change by them.
    Float8 distance(const Position& p, Int8 far) const {
        const Float8 x = absolute(p.along), y = squareRoot(p.across2);
        // Start: outside, the point of the surface towards the center, exact for balls and close to
        // the surface. Inside, where that may be the farthest point, one that is exact on both
        // axes.
        const float longer = std::max(a, b), shorter = form.shorter;
        const Float8 deep = longer * longer + (p.f - 1.0f) * (shorter * shorter);
        Float8 tl = (a < b ? y : x) * longer / choose(p.f < 1.0f, deep, (longer * longer) * p.f);
        tl = choose(tl < 1.0f, tl, 1.0f);
        const Float8 ts = squareRoot(1.0f - tl * tl);
        Float8 tx = a < b ? ts : tl, ty = a < b ? tl : ts;
        for (int round = 0; round < rounds; ++round) step(x, y, tx, ty);
        const Float8 distance = toFoot(x, y, tx, ty);
        if (noneOf(far)) return distance;
        for (int round = rounds; round < kFarRounds; ++round) step(x, y, tx, ty);
        return choose(far, toFoot(x, y, tx, ty), distance);
    }

    /// Of eight voxels. @param h  edge of a voxel, mm.
    Position positionOf(std::size_t block, float h) const {
        const TileBlocks<Dim>& blocks = TileBlocks<Dim>::get();
        std::array<Float8, Dim> x;
        for (std::size_t d = 0; d < Dim; ++d)
            x[d] = (load(blocks.lane[d].data()) + blocks.first[d][block]) * h + start[d];
        return form.position(x);
    }

    Float8 signedDistance(const Position& p, Int8 far) const {
        const Float8 d = distance(p, far);
        return choose(p.f < 1.0f, -d, d);
    }

    void step(const Float8& x, const Float8& y, Float8& tx, Float8& ty) const {
        const float tiny = 1e-12f * a * a;
        const Float8 ex = evoluteA * tx * tx * tx, ey = evoluteB * ty * ty * ty;
        const Float8 rx = a * tx - ex, ry = b * ty - ey;
        const Float8 qx = x - ex, qy = y - ey;
        const Float8 q2 = qx * qx + qy * qy;
        const Float8 ratio = squareRoot((rx * rx + ry * ry) / choose(q2 > tiny, q2, tiny));
        tx = (qx * ratio + ex) * form.inverseA;
        ty = (qy * ratio + ey) * form.inverseB;
        tx = choose(tx > 0.0f, choose(tx < 1.0f, tx, 1.0f), 0.0f);
        ty = choose(ty > 0.0f, choose(ty < 1.0f, ty, 1.0f), 0.0f);
        const Float8 square = tx * tx + ty * ty;
        // The center of a ball: all points of its surface are equally near.
        const auto lost = square < 1e-12f;
        const Float8 inverse = 1.0f / squareRoot(choose(lost, 1.0f, square));
        tx = choose(lost, a < b ? 1.0f : 0.0f, tx * inverse);
        ty = choose(lost, a < b ? 0.0f : 1.0f, ty * inverse);
    }
    Float8 toFoot(const Float8& x, const Float8& y, const Float8& tx, const Float8& ty) const {
        const Float8 dx = a * tx - x, dy = b * ty - y;
        return squareRoot(dx * dx + dy * dy);
    }

    Form<Dim, float> form;
    float a, b;
    int rounds;
    float evoluteA, evoluteB;  ///< (evoluteA tx^3, evoluteB ty^3) is the center of curvature
    std::uint32_t id;
    std::array<float, Dim> start;
};

/// Voids that are stamped together: each block of voxels begins with the nearest of them.
template <int Dim>
struct Tile<Dim>::Batch {
    static constexpr std::size_t kMost = 64;
    using Row = std::array<float, kMost>;

    Batch(const NearVoid<Dim>* voids, std::size_t n, const Vec<Dim>& first)
        : count(n), whole(padded(n)) {
        for (std::size_t i = 0; i < whole; ++i) {
            const Stamp s(*voids[std::min(i, n - 1)].ellipsoid, first);
            for (std::size_t d = 0; d < Dim; ++d) {
                start[d][i] = s.start[d];
                axis[d][i] = s.form.axis[d];
            }
            b[i] = s.form.b;
            shorter[i] = s.form.shorter;
            inverseA[i] = s.form.inverseA;
            inverseB[i] = s.form.inverseB;
            if (i < n) stamps[i] = s;
        }
    }

    /// Lower bounds of the distances from the ball about `x` (relative to the tile's first voxel)
    /// to each void. @return the void with the least bound, the first of equals.
    std::size_t lowerBounds(const std::array<float, Dim>& x, float radius, Row& bounds) const {
        Float8 least = everyLane(kTaken);
        for (std::size_t i = 0; i < whole; i += kLanes) {
            Form<Dim, Float8> form;
            std::array<Float8, Dim> x8;
            for (std::size_t d = 0; d < Dim; ++d) {
                form.axis[d] = load(&axis[d][i]);
                x8[d] = load(&start[d][i]) + x[d];
            }
            form.b = load(&b[i]);
            form.shorter = load(&shorter[i]);
            form.inverseA = load(&inverseA[i]);
            form.inverseB = load(&inverseB[i]);
            const Float8 bound = form.lower(form.position(x8)) - radius;
            store(&bounds[i], bound);
            least = smaller(least, bound);
        }
        for (std::size_t i = count; i < whole; ++i) bounds[i] = kTaken;
        const float nearest = smallest(least);
        std::size_t at = 0;
        while (at + 1 < count && bounds[at] != nearest) ++at;
        return at;
    }

    /// The bound of voids that are stamped already, and of padding: above all others.
    static constexpr float kTaken = std::numeric_limits<float>::infinity();
    std::size_t count, whole;
    std::array<Row, Dim> start, axis;
    Row b, shorter, inverseA, inverseB;
    std::array<Stamp, kMost> stamps;
};

}  // namespace vdbpack
