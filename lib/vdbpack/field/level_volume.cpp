#include "vdbpack/field/level_volume.h"

#include "vdbpack/core/cell_share.h"
#include "vdbpack/core/lanes.h"
#include "vdbpack/core/parallel.h"

#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
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

/// Sums of what `share(accessor, leaf, sums)` adds for each leaf, and of the voxels above the
/// leaves whose value is at most each level; the same for any number of threads.
template <class Share>
std::vector<double> sumsOverLeaves(const FloatGrid& field, const std::vector<float>& levels,
                                   const Share& share) {
    constexpr std::size_t kGrain = 64;
    const openvdb::tree::LeafManager<const FloatGrid::TreeType> leaves(field.tree());
    const std::size_t count = leaves.leafCount(), all = levels.size();
    const std::size_t parts = (count + kGrain - 1) / kGrain;
    std::vector<double> sums(all * parts), total(all);
    parallelFor(std::size_t{0}, parts, [&](std::size_t part) {
        auto accessor = field.getConstAccessor();
        for (std::size_t i = part * kGrain; i < std::min(count, (part + 1) * kGrain); ++i)
            share(accessor, leaves.leaf(i), sums.data() + part * all);
    });
    for (std::size_t i = 0; i < sums.size(); ++i) total[i % all] += sums[i];
    forEachTile(field.tree().root(), [&](float value, double voxels) {
        for (std::size_t i = 0; i < all && value <= levels[i]; ++i) total[i] += voxels;
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

    /// Adds to `sums` the volume of the cells between them in which the trilinear interpolant is at
    /// most each of the levels, which descend.
    void addVolumes(const std::vector<float>& levels, double* sums) const {
        const auto [least, most] = std::minmax_element(std::begin(values_), std::end(values_));
        const auto [first, last] = between(levels, *least, *most);
        for (std::size_t i = 0; i < first; ++i) sums[i] += kEdge * kEdge * kEdge;
        if (first == last) return;
        const std::vector<float> crossing(levels.data() + first, levels.data() + last);
        for (int x = 0; x < kEdge; ++x)
            for (int y = 0; y < kEdge; ++y)
                for (int z = 0; z < kEdge; ++z) addCell(index(x, y, z), crossing, sums + first);
    }

private:
    static constexpr int kAcross = kEdge + 1;
    static int index(int x, int y, int z) { return (x * kAcross + y) * kAcross + z; }

    /// The range of the levels that descend from below `most` to `least`.
    static std::pair<std::size_t, std::size_t> between(const std::vector<float>& levels,
                                                       float least, float most) {
        std::size_t first = 0;
        while (first < levels.size() && levels[first] >= most) ++first;
        std::size_t last = first;
        while (last < levels.size() && levels[last] >= least) ++last;
        return {first, last};
    }

    void addCell(int at, const std::vector<float>& levels, double* sums) const {
        float value[8];
        for (int i = 0; i < 8; ++i) value[i] = values_[at + index(i & 1, i >> 1 & 1, i >> 2)];
        const auto [least, most] = std::minmax_element(std::begin(value), std::end(value));
        const auto [first, last] = between(levels, *least, *most);
        for (std::size_t i = 0; i < first; ++i) sums[i] += 1;
        for (std::size_t i = first; i < last; ++i) {
            float corner[8];
            for (int c = 0; c < 8; ++c) corner[c] = value[c] - levels[i];
            sums[i] += shareBelowZero<3>(corner);
        }
    }

    float values_[kAcross * kAcross * kAcross];
};

}  // namespace

double volumeByVoxels(const FloatGrid& field, float voxelSize) {
    const float inverse = 1 / voxelSize;
    const auto share = [inverse](const FloatGrid::ConstAccessor&, const Leaf& leaf, double* sum) {
        const float* const values = leaf.buffer().data();
        std::array<double, kLanes> lanes{};
        for (std::size_t k = 0; k < Leaf::SIZE; k += kLanes)
            for (std::size_t l = 0; l < kLanes; ++l)
                lanes[l] += std::clamp(0.5f - values[k + l] * inverse, 0.0f, 1.0f);
        *sum += std::accumulate(lanes.begin(), lanes.end(), 0.0);
    };
    return sumsOverLeaves(field, {0}, share)[0];
}

std::vector<double> volumesByCells(const FloatGrid& field, const std::vector<float>& levels) {
    return sumsOverLeaves(field, levels,
                          [&](FloatGrid::ConstAccessor& accessor, const Leaf& leaf, double* sums) {
                              LeafCorners(accessor, leaf).addVolumes(levels, sums);
                          });
}

}  // namespace vdbpack
