#include "vdbpack/field/band_width.h"

#include "vdbpack/field/level_set.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

using openvdb::FloatGrid;

FloatGrid::Ptr widened(const FloatGrid& levelSet, int voxels) {
    return openvdb::tools::dilateSdf(levelSet, voxels, openvdb::tools::NN_FACE, 1,
                                     openvdb::tools::FastSweepingDomain::SWEEP_LESS_THAN_ISOVALUE);
}

void makeFog(FloatGrid& levelSet) {
    openvdb::tools::sdfToFogVolume(levelSet);
}

FloatGrid::Ptr narrowed(const FloatGrid& levelSet, float width) {
    using Leaf = FloatGrid::TreeType::LeafNodeType;
    const FloatGrid::Ptr grid = levelSet.deepCopy();
    openvdb::tree::LeafManager<FloatGrid::TreeType> leafs(grid->tree());
    leafs.foreach ([&](Leaf& leaf, std::size_t) {
        float* const values = leaf.buffer().data();
        Leaf::NodeMaskType on;
        for (openvdb::Index word = 0; word < Leaf::SIZE / 64; ++word) {
            float* const v = values + 64 * word;
            std::uint64_t bits = 0;
            for (unsigned i = 0; i < 64; ++i) bits |= std::uint64_t{std::abs(v[i]) < width} << i;
            on.getWord<std::uint64_t>(word) = bits;
            for (unsigned i = 0; i < 64; ++i) v[i] = std::clamp(v[i], -width, width);
        }
        leaf.setValueMask(on);
    });
    openvdb::tools::changeLevelSetBackground(grid->tree(), width);
    openvdb::tools::pruneLevelSet(grid->tree());
    return grid;
}

std::shared_ptr<const VdbGrid> narrowed(const VdbGrid& grid, double width) {
    return std::make_shared<VdbGrid>(narrowed(*grid.grid, static_cast<float>(width)));
}

}  // namespace vdbpack
