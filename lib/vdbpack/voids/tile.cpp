#include "vdbpack/voids/tile.h"

#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/tile_batch.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

template <int Dim>
Tile<Dim>::Tile(const Vec<Dim>& firstCenter, double voxelSize, double inside, double outside)
    : first_(firstCenter),
      voxelSize_(voxelSize),
      inside_(static_cast<float>(inside)),
      outside_(static_cast<float>(outside)) {
    values_.fill(outside_);
    blockMax_.fill(outside_);
}

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
    const TileBlocks<Dim>& blocks = TileBlocks<Dim>::get();
    const auto h = static_cast<float>(voxelSize_);
    std::array<typename Batch::Row, TileBlocks<Dim>::kCount> bounds;
    std::array<Pair, kMostPairs> pairs;
    std::size_t count = 0;
    for (std::size_t block = 0; block < TileBlocks<Dim>::kCount; ++block) {
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
    for (std::size_t block = 0; block < TileBlocks<Dim>::kCount; ++block) {
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
    const TileBlocks<Dim>& blocks = TileBlocks<Dim>::get();
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
        const TileBlocks<Dim>& blocks = TileBlocks<Dim>::get();
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
    for (std::size_t block = 0; block < TileBlocks<Dim>::kCount; ++block) {
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
    const auto& inLeaf = TileBlocks<Dim>::get().inLeaf;
    for (std::size_t i = 0; i < kTileVoxels<Dim>; ++i) {
        const float v = values_[i];
        values[inLeaf[i] * stride] = v;
        active[inLeaf[i]] = v > -inside_ && v < outside_;
    }
}

template <int Dim>
Vec<Dim> Tile<Dim>::centerOf(std::size_t voxel) const {
    std::size_t at = TileBlocks<Dim>::get().inLeaf[voxel];
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
