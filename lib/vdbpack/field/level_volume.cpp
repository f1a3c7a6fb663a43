#include "vdbpack/field/level_volume.h"

#include "vdbpack/core/cell_share.h"
#include "vdbpack/core/lanes.h"
#include "vdbpack/core/parallel.h"

#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = FloatGrid::TreeType::LeafNodeType;

constexpr int kEdge = static_cast<int>(Leaf::DIM);

/// Calls `visit(value, voxels)` for all values of a tree above its leaves; the tree's own iterator
/// takes as long for them as all leaves do.
template <class Node, class Visit>
void forEachTile(const Node& node, const Visit& visit) {
    using Child = typename Node::ChildNodeType;
    for (auto tile = node.cbeginValueAll(); tile; ++tile)
        visit(*tile, static_cast<double>(Child::NUM_VOXELS));
    if constexpr (Child::LEVEL > 0)
        for (auto child = node.cbeginChildOn(); child; ++child) forEachTile(*child, visit);
}

/// Sum of `share(accessor, leaf)` over the leaves, and of the voxels above them whose value is at
/// most `level`; the same for any number of threads.
template <class Share>
double sumOverLeaves(const FloatGrid& field, float level, const Share& share) {
    const openvdb::tree::LeafManager<const FloatGrid::TreeType> leaves(field.tree());
    std::vector<double> sums(leaves.leafCount());
    parallelFor(IndexRange(0, sums.size(), 64), [&](const IndexRange& range) {
        auto accessor = field.getConstAccessor();
        for (std::size_t i = range.begin(); i != range.end(); ++i)
            sums[i] = share(accessor, leaves.leaf(i));
    });
    double total = std::accumulate(sums.begin(), sums.end(), 0.0);
    forEachTile(field.tree().root(), [&](float value, double voxels) {
        if (value <= level) total += voxels;
    });
    return total;
}

/// The values of a leaf and of the voxels next to it towards higher x, y and z.
class LeafCorners {
public:
    LeafCorners(FloatGrid::ConstAccessor& accessor, const Leaf& leaf) {
        const Coord origin = leaf.origin();
        for (int next = 0; next < 8; ++next) {
            const Coord step(next >> 2, next >> 1 & 1, next & 1);
            const Coord at = origin.offsetBy(step[0] * kEdge, step[1] * kEdge, step[2] * kEdge);
            const Leaf* const from = next == 0 ? &leaf : accessor.probeConstLeaf(at);
            const float flat = from ? 0 : accessor.getValue(at);
            const int count[3] = {step[0] != 0 ? 1 : kEdge, step[1] != 0 ? 1 : kEdge,
                                  step[2] != 0 ? 1 : kEdge};
            for (int x = 0; x < count[0]; ++x)
                for (int y = 0; y < count[1]; ++y) {
                    float* const row =
                        values_ + index(x + step[0] * kEdge, y + step[1] * kEdge, step[2] * kEdge);
                    if (from)
                        std::copy_n(from->buffer().data() + (x * kEdge + y) * kEdge, count[2], row);
                    else
                        std::fill_n(row, count[2], flat);
                }
        }
    }

    /// Volume of the cells between them in which the trilinear interpolant is at most `level`.
    double volume(float level) const {
        const auto [least, most] = std::minmax_element(std::begin(values_), std::end(values_));
        if (*least > level) return 0;
        if (*most <= level) return kEdge * kEdge * kEdge;
        double sum = 0;
        for (int x = 0; x < kEdge; ++x)
            for (int y = 0; y < kEdge; ++y)
                for (int z = 0; z < kEdge; ++z) sum += cell(index(x, y, z), level);
        return sum;
    }

private:
    static constexpr int kAcross = kEdge + 1;
    static int index(int x, int y, int z) { return (x * kAcross + y) * kAcross + z; }

    double cell(int first, float level) const {
        float corner[8];
        for (int i = 0; i < 8; ++i)
            corner[i] = values_[first + index(i & 1, i >> 1 & 1, i >> 2)] - level;
        return shareBelowZero<3>(corner);
    }

    float values_[kAcross * kAcross * kAcross];
};

}  // namespace

double volumeByVoxels(const FloatGrid& field, float voxelSize) {
    const float inverse = 1 / voxelSize;
    return sumOverLeaves(field, 0, [inverse](const FloatGrid::ConstAccessor&, const Leaf& leaf) {
        const float* const values = leaf.buffer().data();
        std::array<double, kLanes> lanes{};
        for (std::size_t k = 0; k < Leaf::SIZE; k += kLanes)
            for (std::size_t l = 0; l < kLanes; ++l)
                lanes[l] += std::clamp(0.5f - values[k + l] * inverse, 0.0f, 1.0f);
        return std::accumulate(lanes.begin(), lanes.end(), 0.0);
    });
}

double volumeByCells(const FloatGrid& field, float level) {
    return sumOverLeaves(field, level,
                         [level](FloatGrid::ConstAccessor& accessor, const Leaf& leaf) {
                             return LeafCorners(accessor, leaf).volume(level);
                         });
}

}  // namespace vdbpack
