#include "vdbpack/field/interior_components.h"

#include "vdbpack/core/parallel.h"

#include <algorithm>

namespace vdbpack {

namespace {

using openvdb::Coord;
using Leaf = InteriorComponents::Leaf;

/// Calls `visit(voxel of the low face, voxel of the high face)` for all pairs along an axis.
template <class Visit>
void forEachOnFaces(int axis, const Visit& visit) {
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            Coord low(0), high(0);
            low[(axis + 1) % 3] = high[(axis + 1) % 3] = i;
            low[(axis + 2) % 3] = high[(axis + 2) % 3] = j;
            high[axis] = 7;
            visit(Leaf::coordToOffset(low), Leaf::coordToOffset(high));
        }
}

}  // namespace

InteriorComponents::InteriorComponents(Tree& tree, const openvdb::CoordBBox& cell,
                                       const std::array<bool, 3>& wraps)
    : tree_(tree), leafs_(tree) {
    parts_.resize(leafs_.leafCount());
    parallelFor(std::size_t{0}, parts_.size(),
                [&](std::size_t n) { search(leafs_.leaf(n), parts_[n]); });
    const std::uint32_t labels = label();
    sets_ = DisjointSets(labels);
    joinLeafs();
    joinTiles();
    for (int d = 0; d < 3; ++d)
        if (wraps[static_cast<std::size_t>(d)]) joinAcross(cell, d);
    count(labels);
}

void InteriorComponents::search(const Leaf& leaf, LeafParts& parts) {
    parts.part.fill(0);
    std::array<std::uint16_t, Leaf::SIZE> stack;
    const float* values = leaf.buffer().data();
    for (std::uint16_t start = 0; start < Leaf::SIZE; ++start) {
        if (values[start] >= 0 || parts.part[start] != 0) continue;
        // 255 parts fit: a leaf of 8³ holds at most 256 voxels without a common face.
        const auto number =
            static_cast<std::uint8_t>(std::min<std::size_t>(parts.voxels.size() + 1, 255));
        if (parts.voxels.size() < 255) parts.voxels.push_back(0);
        std::size_t top = 0;
        stack[top++] = start;
        parts.part[start] = number;
        while (top > 0) {
            const std::uint16_t at = stack[--top];
            ++parts.voxels[number - 1u];
            for (int d = 0; d < 3; ++d) {
                const int shift = 3 * (2 - d), index = at >> shift & 7;
                for (const int step : {-1, 1}) {
                    if (index + step < 0 || index + step > 7) continue;
                    const auto next = static_cast<std::uint16_t>(at + step * (1 << shift));
                    if (values[next] >= 0 || parts.part[next] != 0) continue;
                    parts.part[next] = number;
                    stack[top++] = next;
                }
            }
        }
    }
}

std::uint32_t InteriorComponents::label() {
    std::uint32_t labels = 0;
    for (std::size_t n = 0; n < parts_.size(); ++n) {
        parts_[n].first = labels;
        labels += static_cast<std::uint32_t>(parts_[n].voxels.size());
        leafAt_[leafs_.leaf(n).origin()] = static_cast<std::uint32_t>(n);
    }
    auto tile = tree_.cbeginValueAll();
    tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
        if (*tile < 0) {
            openvdb::CoordBBox box;
            tile.getBoundingBox(box);
            tiles_.push_back({box, labels++});
        }
    std::sort(tiles_.begin(), tiles_.end(),
              [](const Tile& a, const Tile& b) { return a.box.min() < b.box.min(); });
    return labels;
}

/// `kOutside` for a voxel outside.
std::uint32_t InteriorComponents::labelOf(std::size_t leaf, openvdb::Index voxel) const {
    const std::uint8_t p = parts_[leaf].part[voxel];
    return p == 0 ? kOutside : parts_[leaf].first + p - 1;
}

void InteriorComponents::joinLeafs() {
    for (std::size_t n = 0; n < parts_.size(); ++n)
        for (int d = 0; d < 3; ++d) {
            Coord next = leafs_.leaf(n).origin();
            next[d] += 8;
            const auto found = leafAt_.find(next);
            if (found == leafAt_.end()) continue;
            forEachOnFaces(d, [&](openvdb::Index low, openvdb::Index high) {
                const std::uint32_t a = labelOf(n, high), b = labelOf(found->second, low);
                if (a != kOutside && b != kOutside) sets_.join(a, b);
            });
        }
}

/// Joins tiles with the leaves and tiles at their faces, in steps of a leaf.
void InteriorComponents::joinTiles() {
    for (const Tile& t : tiles_)
        for (int d = 0; d < 3; ++d)
            for (const bool above : {false, true}) {
                Coord at = t.box.min();
                at[d] = above ? t.box.max()[d] + 1 : t.box.min()[d] - 8;
                const Coord corner = at;
                const int e = (d + 1) % 3, f = (d + 2) % 3;
                for (at[e] = corner[e]; at[e] <= t.box.max()[e]; at[e] += 8)
                    for (at[f] = corner[f]; at[f] <= t.box.max()[f]; at[f] += 8)
                        joinAt(t, at, d, above);
            }
}

void InteriorComponents::joinAt(const Tile& tile, const Coord& at, int axis, bool above) {
    const auto found = leafAt_.find(at);
    if (found == leafAt_.end()) {
        if (const Tile* other = tileAt(at)) sets_.join(tile.label, other->label);
        return;
    }
    forEachOnFaces(axis, [&](openvdb::Index low, openvdb::Index high) {
        const std::uint32_t label = labelOf(found->second, above ? low : high);
        if (label != kOutside) sets_.join(tile.label, label);
    });
}

/// `kOutside` for a voxel outside.
std::uint32_t InteriorComponents::labelAt(const Coord& voxel) const {
    const auto found = leafAt_.find(voxel & ~7);
    if (found != leafAt_.end()) return labelOf(found->second, Leaf::coordToOffset(voxel));
    const Tile* tile = tileAt(voxel);
    return tile ? tile->label : kOutside;
}

void InteriorComponents::joinAcross(const openvdb::CoordBBox& cell, int axis) {
    const int e = (axis + 1) % 3, f = (axis + 2) % 3;
    Coord low = cell.min(), high = cell.min();
    high[axis] = cell.max()[axis];
    for (low[e] = cell.min()[e]; low[e] <= cell.max()[e]; ++low[e])
        for (low[f] = cell.min()[f]; low[f] <= cell.max()[f]; ++low[f]) {
            high[e] = low[e];
            high[f] = low[f];
            const std::uint32_t a = labelAt(low), b = labelAt(high);
            if (a != kOutside && b != kOutside) sets_.join(a, b);
        }
}

const InteriorComponents::Tile* InteriorComponents::tileAt(const Coord& at) const {
    if (!(tree_.getValue(at) < 0)) return nullptr;
    // Tiles are cubes of few sizes, aligned to them.
    for (const int side : {8, 128, 4096}) {
        const Coord corner = at & ~(side - 1);
        const auto found =
            std::lower_bound(tiles_.begin(), tiles_.end(), corner,
                             [](const Tile& t, const Coord& c) { return t.box.min() < c; });
        if (found != tiles_.end() && found->box.isInside(at)) return &*found;
    }
    return nullptr;
}

void InteriorComponents::count(std::uint32_t labels) {
    sizes_.assign(labels, 0);
    for (const LeafParts& leaf : parts_)
        for (std::size_t p = 0; p < leaf.voxels.size(); ++p)
            sizes_[sets_.find(leaf.first + static_cast<std::uint32_t>(p))] += leaf.voxels[p];
    for (const Tile& t : tiles_) sizes_[sets_.find(t.label)] += t.box.volume();
}

}  // namespace vdbpack
