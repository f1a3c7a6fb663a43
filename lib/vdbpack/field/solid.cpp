#include "vdbpack/field/solid.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/core/error.h"
#include "vdbpack/field/vdb_grid.h"

#include <openvdb/tools/Merge.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>
#include <openvdb/tree/NodeManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <map>
#include <new>
#include <vector>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Tree = FloatGrid::TreeType;
using Leaf = Tree::LeafNodeType;

/// Pieces of one leaf: the voxels inside that share faces within it.
struct LeafPieces {
    std::array<std::uint8_t, Leaf::SIZE> piece;  ///< 0: outside, else 1, 2, ...
    std::uint32_t first = 0;                     ///< number of its piece 1 among all
    std::vector<std::uint32_t> voxels;           ///< of each piece
};

/// The pieces of a level set's inside: flooded leaf by leaf in parallel, then joined across faces.
class Pieces {
public:
    explicit Pieces(Tree& tree) : tree_(tree), leafs_(tree) {
        local_.resize(leafs_.leafCount());
        tbb::parallel_for(std::size_t{0}, local_.size(),
                          [&](std::size_t n) { flood(leafs_.leaf(n), local_[n]); });
        std::uint32_t count = 0;
        for (std::size_t n = 0; n < local_.size(); ++n) {
            local_[n].first = count;
            count += static_cast<std::uint32_t>(local_[n].voxels.size());
            leafAt_[leafs_.leaf(n).origin()] = static_cast<std::uint32_t>(n);
        }
        // Tiles that lie inside, of any size.
        auto tile = tree_.cbeginValueAll();
        tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
        for (; tile; ++tile)
            if (*tile < 0) {
                openvdb::CoordBBox box;
                tile.getBoundingBox(box);
                tiles_.push_back({box, count++});
            }
        std::sort(tiles_.begin(), tiles_.end(),
                  [](const Inner& a, const Inner& b) { return a.box.min() < b.box.min(); });
        sets_ = DisjointSets(count);
        joinLeafs();
        joinTiles();
        size_.assign(count, 0);
        for (const auto& leaf : local_)
            for (std::size_t p = 0; p < leaf.voxels.size(); ++p)
                size_[sets_.find(leaf.first + static_cast<std::uint32_t>(p))] += leaf.voxels[p];
        for (const Inner& t : tiles_) size_[sets_.find(t.piece)] += t.box.volume();
    }

    /// By the number of each piece's set: its voxels, 0 for numbers that name none.
    const std::vector<std::uint64_t>& sizes() const { return size_; }

    /// Calls `visit(leaf, voxel, set)` for each voxel inside, leaf by leaf.
    template <class Visit>
    void forEachVoxel(const Visit& visit) {
        for (std::size_t n = 0; n < local_.size(); ++n)
            for (openvdb::Index v = 0; v < Leaf::SIZE; ++v)
                if (const std::uint8_t p = local_[n].piece[v])
                    visit(leafs_.leaf(n), v, sets_.find(local_[n].first + p - 1));
    }
    /// Makes all outside that belongs to a set for which `keep(set)` is false.
    template <class Keep>
    void drop(float background, const Keep& keep) {
        for (const Inner& t : tiles_)
            if (!keep(sets_.find(t.piece))) tree_.fill(t.box, background, false);
        forEachVoxel([&](Leaf& leaf, openvdb::Index v, std::uint32_t set) {
            if (!keep(set)) leaf.setValueOff(v, background);
        });
    }

private:
    struct Inner {
        openvdb::CoordBBox box;
        std::uint32_t piece;
    };

    static void flood(const Leaf& leaf, LeafPieces& pieces) {
        pieces.piece.fill(0);
        std::array<std::uint16_t, Leaf::SIZE> stack;
        const float* values = leaf.buffer().data();
        for (std::uint16_t start = 0; start < Leaf::SIZE; ++start) {
            if (values[start] >= 0 || pieces.piece[start] != 0) continue;
            // 255 pieces fit: a leaf of 8³ holds at most 256 voxels without a common face.
            const auto number =
                static_cast<std::uint8_t>(std::min<std::size_t>(pieces.voxels.size() + 1, 255));
            if (pieces.voxels.size() < 255) pieces.voxels.push_back(0);
            std::size_t top = 0;
            stack[top++] = start;
            pieces.piece[start] = number;
            while (top > 0) {
                const std::uint16_t at = stack[--top];
                ++pieces.voxels[number - 1u];
                for (int d = 0; d < 3; ++d) {
                    const int shift = 3 * (2 - d), place = at >> shift & 7;
                    for (const int step : {-1, 1}) {
                        if (place + step < 0 || place + step > 7) continue;
                        const auto next = static_cast<std::uint16_t>(at + step * (1 << shift));
                        if (values[next] >= 0 || pieces.piece[next] != 0) continue;
                        pieces.piece[next] = number;
                        stack[top++] = next;
                    }
                }
            }
        }
    }

    /// Number of the piece that a voxel belongs to, of all; `kNone` outside.
    static constexpr std::uint32_t kNone = 0xffffffffu;
    std::uint32_t pieceOf(std::size_t leaf, openvdb::Index voxel) const {
        const std::uint8_t p = local_[leaf].piece[voxel];
        return p == 0 ? kNone : local_[leaf].first + p - 1;
    }

    void joinLeafs() {
        for (std::size_t n = 0; n < local_.size(); ++n)
            for (int d = 0; d < 3; ++d) {
                Coord next = leafs_.leaf(n).origin();
                next[d] += 8;
                const auto found = leafAt_.find(next);
                if (found == leafAt_.end()) continue;
                forEachOnFace(d, [&](openvdb::Index low, openvdb::Index high) {
                    const std::uint32_t a = pieceOf(n, high), b = pieceOf(found->second, low);
                    if (a != kNone && b != kNone) sets_.join(a, b);
                });
            }
    }

    /// Calls `visit(voxel of the low face, voxel of the high face)` along an axis.
    template <class Visit>
    static void forEachOnFace(int d, const Visit& visit) {
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) {
                Coord low(0), high(0);
                low[(d + 1) % 3] = high[(d + 1) % 3] = i;
                low[(d + 2) % 3] = high[(d + 2) % 3] = j;
                high[d] = 7;
                visit(Leaf::coordToOffset(low), Leaf::coordToOffset(high));
            }
    }

    /// Joins tiles with the leaves and tiles at their faces, in steps of a leaf.
    void joinTiles() {
        for (const Inner& t : tiles_)
            for (int d = 0; d < 3; ++d)
                for (const bool up : {false, true}) {
                    Coord at = t.box.min();
                    at[d] = up ? t.box.max()[d] + 1 : t.box.min()[d] - 8;
                    const Coord corner = at;
                    const int e = (d + 1) % 3, f = (d + 2) % 3;
                    for (at[e] = corner[e]; at[e] <= t.box.max()[e]; at[e] += 8)
                        for (at[f] = corner[f]; at[f] <= t.box.max()[f]; at[f] += 8)
                            joinAt(t, at, d, up);
                }
    }

    void joinAt(const Inner& tile, const Coord& at, int d, bool up) {
        const auto found = leafAt_.find(at);
        if (found == leafAt_.end()) {
            if (const Inner* other = tileAt(at)) sets_.join(tile.piece, other->piece);
            return;
        }
        forEachOnFace(d, [&](openvdb::Index low, openvdb::Index high) {
            const std::uint32_t p = pieceOf(found->second, up ? low : high);
            if (p != kNone) sets_.join(tile.piece, p);
        });
    }

    const Inner* tileAt(const Coord& at) const {
        if (!(tree_.getValue(at) < 0)) return nullptr;
        // Tiles are cubes of few sizes, aligned to them.
        for (const int side : {8, 128, 4096}) {
            const Coord corner = at & ~(side - 1);
            const auto found =
                std::lower_bound(tiles_.begin(), tiles_.end(), corner,
                                 [](const Inner& t, const Coord& c) { return t.box.min() < c; });
            if (found != tiles_.end() && found->box.isInside(at)) return &*found;
        }
        return nullptr;
    }

    Tree& tree_;
    openvdb::tree::LeafManager<Tree> leafs_;
    std::vector<LeafPieces> local_;
    std::map<Coord, std::uint32_t> leafAt_;
    std::vector<Inner> tiles_;
    DisjointSets sets_{0};
    std::vector<std::uint64_t> size_;
};

}  // namespace

Solid cutVoids(const VdbGrid& surface, const VdbGrid& voids, double shell, bool keepConnected) {
    if (surface.grid->transform() != voids.grid->transform())
        throw ParameterError("surface and voids lie on different lattices; stamp on the surface's");
    try {
        // `csgDifferenceCopy` never returns where memory ends while it joins what its threads made.
        const FloatGrid::Ptr grid = surface.grid->deepCopy();
        openvdb::tools::CsgDifferenceOp<Tree> difference(voids.grid->constTree(),
                                                         openvdb::DeepCopy());
        openvdb::tree::DynamicNodeManager<Tree>(grid->tree()).foreachTopDown(difference);
        grid->setName("solid");
        grid->setGridClass(openvdb::GRID_LEVEL_SET);
        Pieces pieces(grid->tree());
        const auto& sizes = pieces.sizes();
        Solid solid;
        std::vector<bool> attached(sizes.size());
        std::size_t largest = 0;
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            solid.pieces += sizes[i] > 0;
            if (sizes[i] > sizes[largest]) largest = i;
        }
        if (shell > 0) {
            // What is as near to the wall as the solid itself lies at it.
            const auto wall = surface.grid->getConstAccessor();
            const float background = surface.grid->background();
            pieces.forEachVoxel([&](Leaf& leaf, openvdb::Index v, std::uint32_t set) {
                if (attached[set]) return;
                const float here = wall.getValue(leaf.offsetToGlobalCoord(v));
                attached[set] = here > -background && here == leaf.getValue(v);
            });
        } else if (!sizes.empty()) {
            attached[largest] = true;
        }
        std::uint64_t all = 0, kept = 0;
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            all += sizes[i];
            if (attached[i]) kept += sizes[i];
        }
        solid.attached = all > 0 ? static_cast<double>(kept) / static_cast<double>(all) : 0;
        const double h = grid->voxelSize()[0];
        if (keepConnected) solid.dropped = static_cast<double>(all - kept) * h * h * h;
        if (keepConnected && kept < all)
            pieces.drop(grid->background(), [&](std::uint32_t set) { return attached[set]; });
        openvdb::tools::pruneLevelSet(grid->tree());
        solid.grid = std::make_shared<VdbGrid>(grid);
        return solid;
    } catch (const std::bad_alloc&) {
        throw ResourceError("not enough memory to cut the voids; give a larger `voids.voxelSize`");
    }
}

}  // namespace vdbpack
