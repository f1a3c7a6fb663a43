#include "vdbpack/field/narrow_band.h"

#include "vdbpack/core/lanes.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/band/band_features.h"
#include "vdbpack/field/band/column_crossings.h"
#include "vdbpack/field/band/leaf_distances.h"
#include "vdbpack/field/band/leaf_lists.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/field/vdb_init.h"

#include <algorithm>
#include <memory>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Root = openvdb::FloatTree::RootNodeType;
using Upper = Root::ChildNodeType;
using Node = Upper::ChildNodeType;
using Leaf = Node::ChildNodeType;
static_assert(Leaf::DIM == kLeafSide && Node::DIM == kLeafSide * kNodeSide);

/// Makes the grid from lists of candidates, node by node.
class BandBuilder {
public:
    BandBuilder(const BandMesh& mesh, LeafLists& lists, const ColumnCrossings& crossings,
                double voxelSize, const Callbacks& callbacks)
        : mesh_(mesh),
          lists_(lists),
          crossings_(crossings),
          voxelSize_(static_cast<float>(voxelSize)),
          outside_(static_cast<float>(mesh.outside * voxelSize)),
          inside_(static_cast<float>(-mesh.inside * voxelSize)),
          request_(callbacks.cancelled) {}

    FloatGrid::Ptr build() {
        const std::size_t leafCount = lists_.leaves.size();
        std::vector<std::unique_ptr<Leaf>> leaves(leafCount);
        PerThread<LeafDistances> distances([&] { return LeafDistances(mesh_); });
        parallelFor(IndexRange(0, leafCount, 16), [&](const IndexRange& part) {
            request_.stop();
            LeafDistances& d = distances.local();
            for (std::size_t i = part.begin(); i < part.end(); ++i) {
                leaves[i] = leafOf(lists_.leaves[i], d);
                lists_.leaves[i].squares = nullptr;
            }
        });
        const std::size_t nodeCount = lists_.nodeStart.size() - 1;
        std::vector<std::unique_ptr<Node>> nodes(nodeCount);
        parallelFor(std::size_t{0}, nodeCount, [&](std::size_t n) {
            const std::uint32_t first = lists_.nodeStart[n], last = lists_.nodeStart[n + 1];
            if (std::any_of(leaves.begin() + first, leaves.begin() + last,
                            [](const auto& leaf) { return leaf != nullptr; }))
                nodes[n] = nodeOf(n, leaves);
        });
        request_.stop();
        const auto grid = FloatGrid::create(outside_);
        for (std::size_t n = 0; n < nodeCount; ++n) {
            const auto origin = lists_.nodeOrigin(n);
            const Coord at(origin[0], origin[1], origin[2]);
            const float tile = valueOfTile(at);
            if (!nodes[n] && tile == outside_) continue;
            Root& root = grid->tree().root();
            Upper* upper = root.probeNode<Upper>(at);
            if (!upper) {
                root.addChild(new Upper(at, outside_, false));
                upper = root.probeNode<Upper>(at);
            }
            if (nodes[n])
                upper->addChild(nodes[n].release());
            else
                upper->addTile(Upper::coordToOffset(at), tile, false);
        }
        return grid;
    }

private:
    float valueOfTile(const Coord& at) const {
        return crossings_.inside(at[0], at[1], at[2]) ? inside_ : outside_;
    }

    /// A leaf with its active voxels; null if it has none.
    std::unique_ptr<Leaf> leafOf(const BandLeaf& at, LeafDistances& distances) const {
        distances.start(at);
        for (std::uint64_t k = at.start[0]; k < at.start[1]; ++k)
            distances.addTriangle(lists_.items[k]);
        for (std::uint64_t k = at.start[1]; k < at.start[2]; ++k)
            distances.addEdge(lists_.features.edges[lists_.items[k]]);
        for (std::uint64_t k = at.start[2]; k < at.start[3]; ++k)
            distances.addVertex(lists_.features.vertices[lists_.items[k]]);
        auto leaf = std::make_unique<Leaf>(Coord(at.origin[0], at.origin[1], at.origin[2]),
                                           outside_, false);
        float* const values = leaf->buffer().data();
        Leaf::NodeMaskType active;
        bool any = false;
        constexpr Int8 kBits{1, 2, 4, 8, 16, 32, 64, 128};
        for (unsigned x = 0; x < kLeafSide; ++x) {
            std::uint64_t on = 0;
            for (unsigned y = 0; y < kLeafSide; ++y) {
                const Int8 inside =
                    (kBits & static_cast<std::int32_t>(crossings_.insideOfEight(
                                 at.origin[0] + static_cast<std::int32_t>(x),
                                 at.origin[1] + static_cast<std::int32_t>(y), at.origin[2]))) != 0;
                const Float8 distance = distances.row(x, y);
                const Int8 within =
                    distance < choose(inside, everyLane(mesh_.inside), everyLane(mesh_.outside));
                store(values + kLeafSide * (kLeafSide * x + y),
                      choose(within, choose(inside, -distance, distance) * voxelSize_,
                             choose(inside, everyLane(inside_), everyLane(outside_))));
                on |= std::uint64_t{bitsOf(within)} << (kLeafSide * y);
            }
            active.getWord<openvdb::Index64>(x) = on;
            any |= on != 0;
        }
        if (!any) return nullptr;
        leaf->setValueMask(active);
        return leaf;
    }

    std::unique_ptr<Node> nodeOf(std::size_t n, std::vector<std::unique_ptr<Leaf>>& leaves) const {
        const auto origin = lists_.nodeOrigin(n);
        const Coord first(origin[0], origin[1], origin[2]);
        auto node = std::make_unique<Node>(first, outside_, false);
        std::vector<char> hasLeaf(Node::NUM_VALUES, 0);
        for (std::uint32_t i = lists_.nodeStart[n]; i < lists_.nodeStart[n + 1]; ++i) {
            if (!leaves[i]) continue;
            hasLeaf[Node::coordToOffset(leaves[i]->origin())] = 1;
            node->addLeaf(leaves[i].release());
        }
        for (openvdb::Index k = 0; k < Node::NUM_VALUES; ++k) {
            if (hasLeaf[k]) continue;
            const Coord at = node->offsetToGlobalCoord(k);
            if (valueOfTile(at) == inside_) node->addTile(k, inside_, false);
        }
        return node;
    }

    const BandMesh& mesh_;
    LeafLists& lists_;
    const ColumnCrossings& crossings_;
    const float voxelSize_, outside_, inside_;
    mutable StopRequest request_;
};

BandMesh bandMesh(const TriangleMesh& from, double voxelSize, float inside, float outside,
                  const NarrowBandOptions& options) {
    BandMesh mesh;
    const double perLength = 1 / voxelSize;
    mesh.vertices.resize(from.vertices.size());
    forAll(mesh.vertices.size(), [&](std::size_t v) {
        mesh.vertices[v] = (from.vertices[v] - options.origin) * perLength;
    });
    mesh.triangles = &from.triangles;
    mesh.facing = options.facing ? options.facing->data() : nullptr;
    mesh.bounds = boundsOfAll<3>(from.triangles.size(), [&](std::size_t i, Box<3>& box) {
        for (std::size_t k = 0; k < 3; ++k) box.add(mesh.corner(i, k));
    });
    // No point inside is deeper than halfway through, however deep a band is asked for.
    const Vec<3> size = mesh.bounds.hi - mesh.bounds.lo;
    const double deepest = 0.5 * std::min({size[0], size[1], size[2]}) + 1;
    mesh.inside = std::min(inside, static_cast<float>(deepest));
    mesh.outside = outside;
    return mesh;
}

}  // namespace

FloatGrid::Ptr narrowBand(const TriangleMesh& triangles, double voxelSize, float inside,
                          float outside, const NarrowBandOptions& options,
                          const Callbacks& callbacks) {
    initializeOpenVdb();
    FloatGrid::Ptr grid;
    if (triangles.triangles.empty()) {
        grid = FloatGrid::create(static_cast<float>(outside * voxelSize));
    } else {
        const BandMesh mesh = bandMesh(triangles, voxelSize, inside, outside, options);
        LeafLists lists(mesh, callbacks);
        const ColumnCrossings crossings(mesh, callbacks);
        grid = BandBuilder(mesh, lists, crossings, voxelSize, callbacks).build();
    }
    const Vec<3>& o = options.origin;
    const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
    transform->postTranslate(openvdb::Vec3d(o[0], o[1], o[2]));
    grid->setTransform(transform);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
}

}  // namespace vdbpack
