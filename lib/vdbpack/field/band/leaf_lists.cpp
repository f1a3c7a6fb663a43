#include "vdbpack/field/band/leaf_lists.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

/// Numbers of candidates, then places of the next; three for each leaf.
struct Node {
    std::array<std::array<std::atomic<std::uint64_t>, 3>, kLeavesOfNode> slots{};
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

    void bound(const Vec<3>& normal, const Vec<3>& through) {
        planes[count++] = {normal, kSlack * length(normal) - dot(normal, through)};
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
    region.bound(cross(n, b - a), a);
    region.bound(cross(n, c - b), b);
    region.bound(cross(n, a - c), c);
    region.bound(n, a - n * widths.below);
    region.bound(n * -1.0, a + n * widths.above);
    return region;
}

Region regionOf(const BandMesh& mesh, const BandEdge& edge) {
    const Vec<3>&a = mesh.vertices[edge.a], &b = mesh.vertices[edge.b];
    Region region;
    const Vec<3> reach{{edge.reach, edge.reach, edge.reach}};
    if (edge.c1 == BandEdge::kNone) {
        for (const Vec<3>* x : {&a, &b}) {
            region.box.add(*x + reach);
            region.box.add(*x - reach);
        }
        return region;
    }
    const double l = length(b - a);
    const Vec<3> along = l > 0 ? (b - a) * (1 / l) : Vec<3>{};
    const auto into = [&](std::uint32_t third) {
        const Vec<3> to = mesh.vertices[third] - a;
        const Vec<3> across = to - along * dot(to, along);
        return across * (1 / length(across));
    };
    const Vec<3> u0 = into(edge.c0), u1 = into(edge.c1);
    // The wedge between the normals of its planes; the arc lies below the bisector's end.
    const Vec<3> opens = (u0 + u1) * -1.0;
    const Vec<3> bisector = opens * (1 / length(opens));
    const auto normal = [&](const Vec<3>& u) {
        const Vec<3> n = cross(along, u);
        return dot(n, bisector) > 0 ? n : n * -1.0;
    };
    const Vec<3> n0 = normal(u0), n1 = normal(u1);
    const double cosine = dot(n0, bisector);
    for (const Vec<3>* x : {&a, &b}) {
        region.box.add(*x);
        if (cosine > 0.2) {
            region.box.add(*x + n0 * edge.reach);
            region.box.add(*x + n1 * edge.reach);
            region.box.add(*x + bisector * (edge.reach / cosine));
        } else {
            region.box.add(*x + reach);
            region.box.add(*x - reach);
        }
    }
    region.bound(u0 * -1.0, a);
    region.bound(u1 * -1.0, a);
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

/// Fills lists: counts candidates first, then writes them.
class LeafListsBuilder {
public:
    LeafListsBuilder(LeafLists& lists, const BandMesh& mesh, const BandFeatures& features,
                     const Callbacks& callbacks)
        : lists_(lists), mesh_(mesh), features_(features), callbacks_(callbacks) {
        chooseNodes();
    }
    ~LeafListsBuilder() {
        for (auto& node : nodes_) delete node.load();
    }
    LeafListsBuilder(const LeafListsBuilder&) = delete;
    LeafListsBuilder& operator=(const LeafListsBuilder&) = delete;

    void build() {
        forAllFeatures([&](std::size_t kind, std::uint32_t, const LeafPlace& leaf) {
            slotsOf(leaf)[kind].fetch_add(1, std::memory_order_relaxed);
        });
        callbacks_.stopIfCancelled();
        placeLeaves();
        forAllFeatures([&](std::size_t kind, std::uint32_t index, const LeafPlace& leaf) {
            lists_.items[slotsOf(leaf)[kind].fetch_add(1, std::memory_order_relaxed)] = index;
        });
        callbacks_.stopIfCancelled();
    }

private:
    void chooseNodes() {
        Box<3> box;
        for (const auto& t : *mesh_.triangles)
            for (const auto v : t) box.add(mesh_.vertices[v]);
        box = box.grown(std::max(mesh_.inside, mesh_.outside) + 1);
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

    std::array<std::atomic<std::uint64_t>, 3>& slotsOf(const LeafPlace& leaf) {
        std::array<std::int32_t, 3> node, within;
        for (std::size_t i = 0; i < 3; ++i) {
            node[i] = (leaf[i] >> 4) - lists_.firstNode[i];
            within[i] = leaf[i] & (kNodeSide - 1);
        }
        const auto n =
            (static_cast<std::size_t>(node[2]) * static_cast<std::size_t>(lists_.nodeCount[1]) +
             static_cast<std::size_t>(node[1])) *
                static_cast<std::size_t>(lists_.nodeCount[0]) +
            static_cast<std::size_t>(node[0]);
        Node* at = nodes_[n].load(std::memory_order_acquire);
        if (!at) {
            auto fresh = std::make_unique<Node>();
            if (nodes_[n].compare_exchange_strong(at, fresh.get())) at = fresh.release();
        }
        // As OpenVDB numbers them: z fastest.
        return at->slots[static_cast<std::size_t>((within[0] * kNodeSide + within[1]) * kNodeSide +
                                                  within[2])];
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

    /// Calls `visit(kind, index, leaf)`: kind 0 triangles, 1 edges, 2 vertices.
    template <class Visit>
    void forAllFeatures(const Visit& visit) {
        const auto each = [&](std::size_t kind, std::size_t n, const auto& regionAt) {
            tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 512),
                              [&](const tbb::blocked_range<std::size_t>& part) {
                                  for (std::size_t i = part.begin(); i < part.end(); ++i)
                                      forEachLeaf(regionAt(i), [&](const LeafPlace& leaf) {
                                          visit(kind, static_cast<std::uint32_t>(i), leaf);
                                      });
                              });
        };
        each(0, mesh_.triangles->size(), [&](std::size_t i) { return regionOf(mesh_, i); });
        each(1, features_.edges.size(),
             [&](std::size_t i) { return regionOf(mesh_, features_.edges[i]); });
        each(2, features_.vertices.size(),
             [&](std::size_t i) { return regionOf(mesh_, features_.vertices[i]); });
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
                if (slots[0] + slots[1] + slots[2] == 0) continue;
                BandLeaf leaf{};
                leaf.origin = {origin[0] + (i >> 8) * kLeafSide,
                               origin[1] + (i >> 4 & 15) * kLeafSide,
                               origin[2] + (i & 15) * kLeafSide};
                for (std::size_t kind = 0; kind < 3; ++kind) {
                    leaf.start[kind] = sum;
                    sum += slots[kind].exchange(sum);
                }
                leaf.start[3] = sum;
                lists_.leaves.push_back(leaf);
            }
        }
        lists_.nodeStart.push_back(static_cast<std::uint32_t>(lists_.leaves.size()));
        lists_.items.resize(sum);
    }

    LeafLists& lists_;
    const BandMesh& mesh_;
    const BandFeatures& features_;
    const Callbacks& callbacks_;
    std::vector<std::atomic<Node*>> nodes_;
};

LeafLists::LeafLists(const BandMesh& mesh, const BandFeatures& features,
                     const Callbacks& callbacks) {
    LeafListsBuilder(*this, mesh, features, callbacks).build();
}

std::array<std::int32_t, 3> LeafLists::nodeOrigin(std::size_t n) const {
    const auto nx = static_cast<std::size_t>(nodeCount[0]),
               ny = static_cast<std::size_t>(nodeCount[1]);
    return {(firstNode[0] + static_cast<std::int32_t>(n % nx)) * kNodeVoxels,
            (firstNode[1] + static_cast<std::int32_t>(n / nx % ny)) * kNodeVoxels,
            (firstNode[2] + static_cast<std::int32_t>(n / nx / ny)) * kNodeVoxels};
}

}  // namespace vdbpack
