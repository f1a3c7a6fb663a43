#include "vdbpack/field/band/leaf_lists.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/band/narrow_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

namespace vdbpack {

namespace {

constexpr int kNodeVoxels = kLeafSide * kNodeSide;
constexpr int kLeavesOfNode = kNodeSide * kNodeSide * kNodeSide;
/// Half the distance between the outermost voxels of a leaf.
constexpr double kHalf = 0.5 * (kLeafSide - 1);
/// Boxes and planes are moved out by this much, so that rounding loses no leaf; voxels.
constexpr double kSlack = 1e-4;

/// Leaf coordinates: voxels divided by 8.
using LeafPlace = std::array<std::int32_t, 3>;

/// Regions with at most this many voxels side by side are visited voxel by voxel.
constexpr double kNarrow = 2;

constexpr std::size_t kKinds = 3;  ///< triangles, edges, vertices

/// For each leaf: the number of candidates of each kind, then the place of the next; the squares of
/// its voxels, once a small triangle is near.
struct Node {
    std::uint32_t number = 0;
    std::array<std::array<std::atomic<std::uint64_t>, kKinds>, kLeavesOfNode> slots{};
    std::array<std::atomic<LeafSquares*>, kLeavesOfNode> squares{};

    Node() = default;
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;
    ~Node() {
        for (auto& mine : squares) delete mine.load(std::memory_order_relaxed);
    }

    LeafSquares& squaresOf(std::uint32_t leaf) {
        LeafSquares* mine = squares[leaf].load(std::memory_order_acquire);
        if (mine) return *mine;
        auto made = std::make_unique<LeafSquares>();
        for (auto& square : *made)
            square.store(std::numeric_limits<float>::infinity(), std::memory_order_relaxed);
        // Another thread may have been first.
        if (squares[leaf].compare_exchange_strong(mine, made.get(), std::memory_order_acq_rel))
            mine = made.release();
        return *mine;
    }
};

void lower(std::atomic<float>& to, float value) {
    float before = to.load(std::memory_order_relaxed);
    while (value < before && !to.compare_exchange_weak(before, value, std::memory_order_relaxed))
        continue;
}

/// A candidate of a leaf.
struct Entry {
    std::uint32_t leaf;  ///< number of the node, by 4096, and of the leaf in it
    std::uint32_t index;
};

/// Points with normal * x + offset >= 0.
struct HalfSpace {
    Vec<3> normal;
    double offset = 0;
    bool meets(const Vec<3>& center) const {
        const double support = std::abs(normal[0]) + std::abs(normal[1]) + std::abs(normal[2]);
        return dot(normal, center) + offset + kHalf * support >= 0;
    }
};

/// A convex region: a box and half-spaces.
struct Region {
    Box<3> box;
    std::array<HalfSpace, 5> planes;
    std::size_t count = 0;

    void bound(const Vec<3>& normal, const Vec<3>& through, double slack = kSlack) {
        planes[count++] = {normal, slack * length(normal) - dot(normal, through)};
    }
    bool meets(const LeafPlace& leaf) const {
        const Vec<3> center{{leaf[0] * 8 + kHalf, leaf[1] * 8 + kHalf, leaf[2] * 8 + kHalf}};
        for (std::size_t k = 0; k < count; ++k)
            if (!planes[k].meets(center)) return false;
        return true;
    }
};

Region regionOf(const BandMesh& mesh, std::size_t triangle) {
    const Vec<3>&a = mesh.corner(triangle, 0), &b = mesh.corner(triangle, 1),
          &c = mesh.corner(triangle, 2);
    Region region;
    const Vec<3> n = bandNormal(a, b, c);
    if (!(squaredLength(n) > 0)) return region;  // an empty box
    const BandWidths widths = mesh.widths(triangle);
    for (const Vec<3>* x : {&a, &b, &c}) {
        region.box.add(*x + n * widths.above);
        region.box.add(*x - n * widths.below);
    }
    const double gap = kFlat * widths.larger();
    region.box = region.box.grown(gap);
    region.bound(cross(n, b - a), a, kSlack + gap);
    region.bound(cross(n, c - b), b, kSlack + gap);
    region.bound(cross(n, a - c), c, kSlack + gap);
    region.bound(n, a - n * widths.below);
    region.bound(n * -1.0, a + n * widths.above);
    return region;
}

Region regionOf(const BandMesh& mesh, const BandEdge& edge) {
    const Vec<3>&a = mesh.vertices[edge.a], &b = mesh.vertices[edge.b];
    Box<3> ends;
    for (const Vec<3>* x : {&a, &b}) ends.add(*x);
    Region region;
    region.box = ends.grown(edge.reach);
    if (!edge.hasWedge()) return region;
    const Vec<3> inward0 = edge.inward0(b - a), inward1 = edge.inward1(b - a);
    const Vec<3> opens = inward0 + inward1, middle = opens * (1 / length(opens));
    // The arc lies below the end of the middle, and within reach.
    const double cosine = dot(edge.n0, middle);
    if (cosine > 0.2) {
        Box<3> wedgeBox = ends;
        for (const Vec<3>* x : {&a, &b}) {
            wedgeBox.add(*x + edge.n0 * edge.reach);
            wedgeBox.add(*x + edge.n1 * edge.reach);
            wedgeBox.add(*x + middle * (edge.reach / cosine));
        }
        region.box = intersection(region.box, wedgeBox);
    }
    region.bound(inward0, a);
    region.bound(inward1, a);
    return region;
}

Region regionOf(const BandMesh& mesh, const BandVertex& v) {
    Region region;
    const Vec<3>& x = mesh.vertices[v.vertex];
    region.box.add(x);
    if (!(v.cosine > 0)) {
        region.box = Box<3>{x, x}.grown(v.reach);
        return region;
    }
    const double c = v.cosine, s = std::sqrt(std::max(0.0, 1 - c * c));
    for (int i = 0; i < 3; ++i) {
        const double a = v.axis[static_cast<std::size_t>(i)];
        const double across = std::sqrt(std::max(0.0, 1 - a * a)) * s;
        // The extremes of the cone's unit vectors along the axis.
        const double high = a >= c ? 1 : a * c + across, low = -a >= c ? -1 : a * c - across;
        region.box.hi[i] = x[i] + v.reach * std::max(0.0, high);
        region.box.lo[i] = x[i] + v.reach * std::min(0.0, low);
    }
    return region;
}

}  // namespace

/// Fills lists: finds and counts candidates first, then writes them in order of leaves.
class LeafListsBuilder {
public:
    LeafListsBuilder(LeafLists& lists, const BandMesh& mesh, const Callbacks& callbacks)
        : lists_(lists), mesh_(mesh), callbacks_(callbacks) {
        chooseNodes();
    }

    void build() {
        find(
            0, mesh_.triangles->size(), [&](std::size_t i) { return takeNarrow(i); },
            [&](std::size_t i) { return regionOf(mesh_, i); });
        BandFeatures& features = lists_.features;
        features = bandFeatures(mesh_,
                                {[&](const BandEdge& edge) { return takeNarrow(edge); },
                                 [&](const BandVertex& vertex) { return takeNarrow(vertex); }},
                                callbacks_);
        const auto findAll = [&](std::size_t kind, const auto& candidates) {
            find(
                kind, candidates.end(), [&](std::size_t i) { return !candidates.holds(i); },
                [&](std::size_t i) { return regionOf(mesh_, candidates[i]); });
        };
        findAll(1, features.edges);
        findAll(2, features.vertices);
        placeLeaves();
        for (Found& mine : found_)
            for (std::size_t kind = 0; kind < kKinds; ++kind) moveItems(mine[kind], kind);
    }

private:
    /// What one thread found, by kind.
    using Found = std::array<BlockList<Entry>, kKinds>;

    void moveItems(BlockList<Entry>& entries, std::size_t kind) {
        parallelFor(std::size_t{0}, entries.blockCount(), [&](std::size_t block) {
            entries.consume(block, [&](const Entry& entry) {
                auto& slots = byNumber_[entry.leaf >> 12]->slots[entry.leaf & 4095u];
                lists_.items[slots[kind].fetch_add(1, std::memory_order_relaxed)] = entry.index;
            });
        });
        callbacks_.stopIfCancelled();
    }

    void chooseNodes() {
        // Narrow regions may reach out of the band by as much as they are wide.
        const Box<3> box = mesh_.bounds.grown(std::max(mesh_.inside, mesh_.outside) + kNarrow + 1);
        double count = 1;
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            if (!(std::abs(box.lo[i]) < 1e9 && std::abs(box.hi[i]) < 1e9))
                throw ResourceError(fmt::format(
                    "the field would have {:.3g} voxels along an axis; give a larger `voxelSize`",
                    box.hi[i] - box.lo[i]));
            lists_.firstNode[k] = static_cast<std::int32_t>(std::floor(box.lo[i] / kNodeVoxels));
            lists_.nodeCount[k] = static_cast<std::int32_t>(std::floor(box.hi[i] / kNodeVoxels)) -
                                  lists_.firstNode[k] + 1;
            count *= lists_.nodeCount[k];
        }
        if (!(count < 0x1p31))
            throw ResourceError(fmt::format(
                "the field would have {:.3g} nodes of 128^3 voxels; give a larger `voxelSize`",
                count));
        nodes_ = std::vector<std::atomic<Node*>>(static_cast<std::size_t>(count));
    }

    /// The node of a leaf, made if there is none yet.
    Node& nodeOf(const LeafPlace& leaf) {
        std::array<std::size_t, 3> node;
        for (std::size_t i = 0; i < 3; ++i)
            node[i] = static_cast<std::size_t>((leaf[i] >> 4) - lists_.firstNode[i]);
        const auto n = (node[2] * static_cast<std::size_t>(lists_.nodeCount[1]) + node[1]) *
                           static_cast<std::size_t>(lists_.nodeCount[0]) +
                       node[0];
        Node* at = nodes_[n].load(std::memory_order_acquire);
        if (at) return *at;
        const std::lock_guard<std::mutex> lock(making_);
        at = nodes_[n].load(std::memory_order_relaxed);
        if (at) return *at;
        if (byNumber_.size() == std::size_t{1} << 20)
            throw ResourceError(
                "the field would have more than a million nodes of 128^3 voxels; give a larger "
                "`voxelSize`");
        byNumber_.push_back(std::make_unique<Node>());
        at = byNumber_.back().get();
        at->number = static_cast<std::uint32_t>(byNumber_.size() - 1);
        nodes_[n].store(at, std::memory_order_release);
        return *at;
    }

    /// As OpenVDB numbers the leaves of a node: z fastest.
    static std::uint32_t numberInNode(const LeafPlace& leaf) {
        constexpr int kMask = kNodeSide - 1;
        return static_cast<std::uint32_t>(
            ((leaf[0] & kMask) * kNodeSide + (leaf[1] & kMask)) * kNodeSide + (leaf[2] & kMask));
    }

    template <class Visit>
    static void forEachLeaf(const Region& region, const Visit& visit) {
        if (!(region.box.lo[0] <= region.box.hi[0])) return;
        LeafPlace lo, hi, at;
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            // A leaf's voxels are at 8 i to 8 i + 7.
            lo[k] = static_cast<std::int32_t>(
                std::ceil((region.box.lo[i] - kSlack - (kLeafSide - 1)) / kLeafSide));
            hi[k] = static_cast<std::int32_t>(std::floor((region.box.hi[i] + kSlack) / kLeafSide));
        }
        for (at[0] = lo[0]; at[0] <= hi[0]; ++at[0])
            for (at[1] = lo[1]; at[1] <= hi[1]; ++at[1])
                for (at[2] = lo[2]; at[2] <= hi[2]; ++at[2])
                    if (region.meets(at)) visit(at);
    }

    /// Counts the candidates of one kind for each leaf, and lists them.
    /// @param taken  whether number i is dealt with already.
    template <class Taken, class RegionAt>
    void find(std::size_t kind, std::size_t count, const Taken& taken, const RegionAt& regionAt) {
        parallelFor(IndexRange(0, count, 512), [&](const IndexRange& part) {
            BlockList<Entry>& entries = found_.local()[kind];
            for (std::size_t i = part.begin(); i < part.end(); ++i) {
                if (taken(i)) continue;
                forEachLeaf(regionAt(i), [&](const LeafPlace& leaf) {
                    Node& node = nodeOf(leaf);
                    const std::uint32_t k = numberInNode(leaf);
                    node.slots[k][kind].fetch_add(1, std::memory_order_relaxed);
                    entries.add({node.number << 12 | k, static_cast<std::uint32_t>(i)});
                });
            }
        });
        callbacks_.stopIfCancelled();
    }

    /// Lowers the squares of the voxels in a region.
    /// @param base  the lattice point that the region and `squares` are relative to.
    template <class Squares>
    void visitVoxels(const NarrowRegion& region, const Vec<3>& base, const Squares& squares) {
        LeafPlace lastLeaf;
        LeafSquares* last = nullptr;
        region.visit(squares, [&](std::array<std::int32_t, 3> x, float square) {
            LeafPlace leaf;
            for (std::size_t i = 0; i < 3; ++i) {
                x[i] += static_cast<std::int32_t>(base.c[i]);
                leaf[i] = x[i] >> 3;
            }
            if (!last || leaf != lastLeaf) {
                last = &nodeOf(leaf).squaresOf(numberInNode(leaf));
                lastLeaf = leaf;
            }
            const auto in = [&](std::size_t i) { return static_cast<std::uint32_t>(x[i]) & 7u; };
            lower((*last)[voxelInLeaf(in(0), in(1), in(2))], square);
        });
    }

    // Visit the voxels that may be nearest to a feature. @return false if its region is not narrow.

    bool takeNarrow(std::size_t triangle) {
        const Vec<3>&a = mesh_.corner(triangle, 0), &b = mesh_.corner(triangle, 1),
              &c = mesh_.corner(triangle, 2);
        const Vec<3> n = bandNormal(a, b, c);
        if (!(squaredLength(n) > 0)) return true;
        if (isLong(b - a) || isLong(c - b) || isLong(a - c)) return false;
        const Vec<3> base = latticePoint(a);
        const std::array<Vec<3>, 3> abc{a - base, b - base, c - base};
        const BandWidths widths = mesh_.widths(triangle);
        const auto region = NarrowRegion::over(abc, n, widths);
        if (!region.isNarrow(kNarrow)) return false;
        visitVoxels(region, base, TriangleSquares(abc, n, widths));
        return true;
    }
    bool takeNarrow(const BandEdge& edge) {
        const Vec<3>&a = mesh_.vertices[edge.a], &b = mesh_.vertices[edge.b];
        if (!edge.hasWedge() || isLong(b - a)) return false;
        const Vec<3> base = latticePoint(a);
        const std::array<Vec<3>, 2> ab{a - base, b - base};
        const auto region = NarrowRegion::over(ab, edge.n0, edge.n1, edge.reach);
        if (!region.isNarrow(kNarrow)) return false;
        visitVoxels(region, base, EdgeSquares(ab, edge));
        return true;
    }
    bool takeNarrow(const BandVertex& v) {
        const Vec<3> base = latticePoint(mesh_.vertices[v.vertex]);
        const Vec<3> apex = mesh_.vertices[v.vertex] - base;
        const auto region =
            NarrowRegion::over(apex, {{v.axis[0], v.axis[1], v.axis[2]}}, v.cosine, v.reach);
        if (!region.isNarrow(kNarrow)) return false;
        visitVoxels(region, base, PointSquares(apex));
        return true;
    }
    /// Whether the region over this side is too wide along one of the axes across it.
    static bool isLong(const Vec<3>& side) { return squaredLength(side) > 2 * kNarrow * kNarrow; }
    static Vec<3> latticePoint(const Vec<3>& near) {
        return {{std::floor(near[0]), std::floor(near[1]), std::floor(near[2])}};
    }

    void placeLeaves() {
        std::uint64_t sum = 0;
        lists_.nodeStart.reserve(nodes_.size() + 1);
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            lists_.nodeStart.push_back(static_cast<std::uint32_t>(lists_.leaves.size()));
            Node* const node = nodes_[n].load();
            if (!node) continue;
            const auto origin = lists_.nodeOrigin(n);
            for (int i = 0; i < kLeavesOfNode; ++i) {
                auto& slots = node->slots[static_cast<std::size_t>(i)];
                BandLeaf leaf;
                leaf.squares.reset(node->squares[static_cast<std::size_t>(i)].exchange(nullptr));
                if (slots[0] + slots[1] + slots[2] == 0 && !leaf.squares) continue;
                leaf.origin = {origin[0] + (i >> 8) * kLeafSide,
                               origin[1] + (i >> 4 & 15) * kLeafSide,
                               origin[2] + (i & 15) * kLeafSide};
                for (std::size_t kind = 0; kind < kKinds; ++kind) {
                    leaf.start[kind] = sum;
                    sum += slots[kind].exchange(sum);
                }
                leaf.start[kKinds] = sum;
                lists_.leaves.push_back(std::move(leaf));
            }
        }
        lists_.nodeStart.push_back(static_cast<std::uint32_t>(lists_.leaves.size()));
        lists_.items.resize(sum);
    }

    LeafLists& lists_;
    const BandMesh& mesh_;
    const Callbacks& callbacks_;
    std::vector<std::atomic<Node*>> nodes_;
    std::mutex making_;
    std::vector<std::unique_ptr<Node>> byNumber_;
    PerThread<Found> found_;
};

LeafLists::LeafLists(const BandMesh& mesh, const Callbacks& callbacks) {
    LeafListsBuilder(*this, mesh, callbacks).build();
}

std::array<std::int32_t, 3> LeafLists::nodeOrigin(std::size_t n) const {
    const auto nx = static_cast<std::size_t>(nodeCount[0]),
               ny = static_cast<std::size_t>(nodeCount[1]);
    return {(firstNode[0] + static_cast<std::int32_t>(n % nx)) * kNodeVoxels,
            (firstNode[1] + static_cast<std::int32_t>(n / nx % ny)) * kNodeVoxels,
            (firstNode[2] + static_cast<std::int32_t>(n / nx / ny)) * kNodeVoxels};
}

}  // namespace vdbpack
