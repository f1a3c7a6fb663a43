#include "vdbpack/field/band_width.h"

#include "vdbpack/field/level_set.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/Prune.h>

#include <cmath>

namespace vdbpack {

using openvdb::FloatGrid;

FloatGrid::Ptr widened(const FloatGrid& levelSet, int voxels) {
    return openvdb::tools::dilateSdf(levelSet, voxels, openvdb::tools::NN_FACE, 1,
                                     openvdb::tools::FastSweepingDomain::SWEEP_LESS_THAN_ISOVALUE);
}

FloatGrid::Ptr narrowed(const FloatGrid& levelSet, float width) {
    using Leaf = FloatGrid::TreeType::LeafNodeType;
    const FloatGrid::Ptr grid = levelSet.deepCopy();
    openvdb::tree::LeafManager<FloatGrid::TreeType> leafs(grid->tree());
    leafs.foreach ([&](Leaf& leaf, std::size_t) {
        for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
            const float value = leaf.getValue(i);
            if (std::abs(value) < width)
                leaf.setValueOn(i, value);
            else
                leaf.setValueOff(i, std::copysign(width, value));
        }
    });
    openvdb::tools::changeLevelSetBackground(grid->tree(), width);
    openvdb::tools::pruneLevelSet(grid->tree());
    return grid;
}

std::shared_ptr<const VdbGrid> narrowed(const VdbGrid& grid, double width) {
    return std::make_shared<VdbGrid>(narrowed(*grid.grid, static_cast<float>(width)));
}

}  // namespace vdbpack
