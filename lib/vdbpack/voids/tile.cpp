#include "vdbpack/voids/tile.h"

#include "vdbpack/core/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vdbpack {

namespace {

/// Blocks of eight neighboring voxels, which are stamped at once: 2 x 2 x 2, in the plane 2 x 4.
template <int Dim>
struct Blocks {
    static constexpr std::size_t kCount = kTileVoxels<Dim> / kLanes;
    static_assert(kCount % kLanes == 0);

    Blocks() {
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

    static const Blocks& get() {
        static const Blocks blocks;
        return blocks;
    }
};

/// Iterations of `Stamp::distance` for ellipsoids with a / b from 1 to `kPlainRatio`, for other
/// ellipsoids, and beyond the band. The error is below 1e-5 of the shorter half-axis next to the
/// surface and below 2e-3 elsewhere, up to a ratio of 10.
constexpr float kPlainRatio = 3.2f;
constexpr int kRounds = 2, kLongRounds = 3, kFarRounds = 6;

}  // namespace

template <int Dim>
Tile<Dim>::Tile(const Vec<Dim>& firstCenter, double voxelSize, double inside, double outside)
    : first_(firstCenter),
      voxelSize_(voxelSize),
      inside_(static_cast<float>(inside)),
      outside_(static_cast<float>(outside)) {
    values_.fill(outside_);
    blockMax_.fill(outside_);
}

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
        const Blocks<Dim>& blocks = Blocks<Dim>::get();
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

template <int Dim>
void Tile<Dim>::stamp(const std::vector<NearVoid<Dim>>& voids) {
    for (std::size_t i = 0; i < voids.size(); i += Batch::kMost) {
        const float most = *std::max_element(blockMax_.begin(), blockMax_.end());
        std::size_t n = std::min(voids.size() - i, Batch::kMost);
        while (n > 0 && !(static_cast<float>(voids[i + n - 1].lower) < most)) --n;
        if (n == 0) return;
        stamp(Batch(&voids[i], n, first_));
    }
}

/// The nearest void of each block is stamped first: most others then change nothing.
template <int Dim>
void Tile<Dim>::stamp(const Batch& batch) {
    const Blocks<Dim>& blocks = Blocks<Dim>::get();
    const auto h = static_cast<float>(voxelSize_);
    std::array<typename Batch::Row, Blocks<Dim>::kCount> bounds;
    std::array<Pair, kMostPairs> pairs;
    std::size_t count = 0;
    for (std::size_t block = 0; block < Blocks<Dim>::kCount; ++block) {
        std::array<float, Dim> middle;
        for (std::size_t d = 0; d < Dim; ++d)
            middle[d] = (blocks.first[d][block] + blocks.middle[d]) * h;
        auto& row = bounds[block];
        const std::size_t nearest = batch.lowerBounds(middle, blocks.radius * h, row);
        pairs[count] = {static_cast<std::uint16_t>(block), static_cast<std::uint16_t>(nearest)};
        count += row[nearest] < blockMax_[block];
        row[nearest] = Batch::kTaken;
    }
    stamp(batch, pairs, count);
    count = 0;
    for (std::size_t block = 0; block < Blocks<Dim>::kCount; ++block) {
        for (std::size_t i = 0; i < batch.whole; i += kLanes)
            forEachSet(load(&bounds[block][i]) < blockMax_[block], [&](std::size_t n) {
                pairs[count++] = {static_cast<std::uint16_t>(block),
                                  static_cast<std::uint16_t>(i + n)};
            });
        if (count + batch.whole > kMostPairs) {
            stamp(batch, pairs, count);
            count = 0;
        }
    }
    stamp(batch, pairs, count);
}

/// Two loops without branches, so that the long dependency chains of `distance` overlap.
template <int Dim>
void Tile<Dim>::stamp(const Batch& batch, std::array<Pair, kMostPairs>& pairs, std::size_t count) {
    const Blocks<Dim>& blocks = Blocks<Dim>::get();
    const auto h = static_cast<float>(voxelSize_);
    std::array<Float8, Dim> lane, x;
    for (std::size_t d = 0; d < Dim; ++d) lane[d] = load(blocks.lane[d].data());
    const auto positionOf = [&](const Pair& pair) {
        const Stamp& stamp = batch.stamps[pair.ellipsoid];
        for (std::size_t d = 0; d < Dim; ++d)
            x[d] = (lane[d] + blocks.first[d][pair.block]) * h + stamp.start[d];
        return stamp.form.position(x);
    };
    std::size_t left = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Pair pair = pairs[i];
        const Float8 least = batch.stamps[pair.ellipsoid].form.lower(positionOf(pair));
        pairs[left] = pair;
        left += noneOf(least < load(&values_[pair.block * kLanes])) ? 0 : 1;
    }
    for (std::size_t i = 0; i < left; ++i) {
        const Pair pair = pairs[i];
        const Stamp& stamp = batch.stamps[pair.ellipsoid];
        const auto position = positionOf(pair);
        // Beyond the band of the level set, if distances there are wanted.
        const auto far = outside_ > inside_ ? stamp.form.lower(position) > inside_ : Int8{};
        const Float8 distance = stamp.distance(position, far);
        Float8 here = choose(position.f < 1.0f, -distance, distance);
        here = choose(here < -inside_, -inside_, here);
        float* const values = &values_[pair.block * kLanes];
        const Float8 value = smaller(load(values), here);
        store(values, value);
        blockMax_[pair.block] = largest(value);
    }
}

/// Voids near a tile, block by block with bounds of their distances.
template <int Dim>
class Tile<Dim>::Neighborhood {
public:
    Neighborhood(const std::vector<NearVoid<Dim>>& voids, double reach, const Vec<Dim>& first) {
        std::vector<NearVoid<Dim>> near;
        for (const NearVoid<Dim>& v : voids)
            if (v.lower < reach) near.push_back(v);
        count_ = near.size();
        for (std::size_t i = 0; i < count_; i += Batch::kMost)
            batches_.emplace_back(&near[i], std::min(count_ - i, Batch::kMost), first);
        bounds_.resize(batches_.size());
    }

    std::size_t count() const { return count_; }

    /// Turns to a block. @return a lower bound of the distances to all voids
    float turnTo(std::size_t block, float h) {
        const Blocks<Dim>& blocks = Blocks<Dim>::get();
        std::array<float, Dim> middle;
        for (std::size_t d = 0; d < Dim; ++d)
            middle[d] = (blocks.first[d][block] + blocks.middle[d]) * h;
        float least = Batch::kTaken;
        for (std::size_t k = 0; k < batches_.size(); ++k) {
            const std::size_t at = batches_[k].lowerBounds(middle, blocks.radius * h, bounds_[k]);
            least = std::min(least, bounds_[k][at]);
        }
        return least;
    }

    /// Calls `visit(stamp)` for the voids whose bound is below what `limit()` is by then.
    template <class Limit, class Visit>
    void forEachWithin(const Limit& limit, const Visit& visit) const {
        for (std::size_t k = 0; k < batches_.size(); ++k)
            for (std::size_t i = 0; i < batches_[k].count; ++i)
                if (bounds_[k][i] < limit()) visit(batches_[k].stamps[i]);
    }

private:
    std::size_t count_ = 0;
    std::vector<Batch> batches_;
    std::vector<typename Batch::Row> bounds_;
};

template <int Dim>
void Tile<Dim>::join(const std::vector<NearVoid<Dim>>& voids, const VoidJoin& how) {
    using Nearest = NearestVoids<Dim, Float8, Word8>;
    const auto h = static_cast<float>(voxelSize_);
    Neighborhood near(voids, how.reach(voxelSize_), first_);
    if (near.count() < 2) return;
    const bool hasStruts = how.strut > 0 && how.strutShare > 0 && near.count() >= Dim;
    const auto reach = static_cast<float>(kBlendReach * how.blend);
    const std::uint32_t below = Nearest::below(how.strutShare);
    for (std::size_t block = 0; block < Blocks<Dim>::kCount; ++block) {
        float* const values = &values_[block * kLanes];
        const Float8 before = load(values);
        const float least = near.turnTo(block, h);
        const bool blends = how.blend > 0 && least < reach && largest(before) > -inside_;
        if (!blends && !(hasStruts && smallest(before) < inside_)) continue;
        Float8 sum{};
        Nearest found;
        float farthest = hasStruts ? Batch::kTaken : -Batch::kTaken;
        const auto limit = [&] { return blends ? std::max(reach, farthest) : farthest; };
        near.forEachWithin(limit, [&](const Stamp& stamp) {
            const auto position = stamp.positionOf(block, h);
            const Float8 lower = stamp.form.lower(position);
            const bool joins = blends && !noneOf(lower < reach);
            const bool bounds = hasStruts && !noneOf(lower < found.farthest());
            if (!joins && !bounds) return;
            const Float8 distance =
                stamp.signedDistance(position, joins ? lower > inside_ : Int8{});
            if (joins) {
                const Float8 share = 1.0f - distance / reach;
                const Float8 square = choose(share > 0.0f, share * share, 0.0f);
                sum += square * square;
            }
            if (bounds) {
                found.add(distance, Word8{} + stamp.id);
                farthest = largest(found.farthest());
            }
        });
        Float8 value = before;
        if (blends) {
            const Float8 blended = reach * (1.0f - squareRoot(squareRoot(sum)));
            value = choose(sum > 0.0f, smaller(before, blended), before);
            value = choose(value < -inside_, -inside_, value);
        }
        if (hasStruts && smallest(value) < inside_) value = withStruts(value, found, below, how);
        store(values, value);
        blockMax_[block] = largest(value);
    }
}

/// Eight distances with the struts between the nearest voids, rounded where they meet the solid.
template <int Dim>
template <class Nearest>
Float8 Tile<Dim>::withStruts(Float8 before, const Nearest& found, std::uint32_t below,
                             const VoidJoin& how) const {
    const auto radius = static_cast<float>(how.strut),
               rounding = static_cast<float>(how.rounding());
    // Where the band cut off how deep the point lies.
    const Float8 depth = choose(before > -inside_, before, smaller(before, found.nearest()));
    const Float8 strut = radius - squareRoot(found.squareFromLine());
    const Int8 kept = bitsAs<Int8>(found.chance() < below);
    const Float8 value = choose(kept, roundedMax(depth, strut, rounding), before);
    return choose(value > outside_, outside_, choose(value < -inside_, -inside_, value));
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
std::size_t Tile<Dim>::countInside() const {
    int count = 0;
    for (const float v : values_) count += v < 0 ? 1 : 0;
    return static_cast<std::size_t>(count);
}

template <int Dim>
void Tile<Dim>::copyTo(float* values, std::size_t stride,
                       std::bitset<kTileVoxels<Dim>>& active) const {
    const auto& inLeaf = Blocks<Dim>::get().inLeaf;
    for (std::size_t i = 0; i < kTileVoxels<Dim>; ++i) {
        const float v = values_[i];
        values[inLeaf[i] * stride] = v;
        active[inLeaf[i]] = v > -inside_ && v < outside_;
    }
}

template <int Dim>
Vec<Dim> Tile<Dim>::centerOf(std::size_t voxel) const {
    std::size_t at = Blocks<Dim>::get().inLeaf[voxel];
    Vec<Dim> x = first_;
    for (int d = Dim - 1; d >= 0; --d) {
        x[d] += static_cast<double>(at % kTileSide) * voxelSize_;
        at /= kTileSide;
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
    const double a2 = e.a * e.a, b2 = e.b * e.b;
    const double steep = std::sqrt(along * along / (a2 * a2) + across / (b2 * b2));
    bounds.lower = (f > 1 ? (f - 1) * f / steep : -std::min(shorter, (1 - f) * longer)) - radius;
    bounds.upper = (f > 1 ? far * (1 - 1 / f) : (f - 1) * shorter) + radius;
    return bounds;
}

template class Tile<2>;
template class Tile<3>;
template VoidAtTile<2> boundsAt(const Ellipsoid<2>&, const Vec<2>&, double);
template VoidAtTile<3> boundsAt(const Ellipsoid<3>&, const Vec<3>&, double);

}  // namespace vdbpack
