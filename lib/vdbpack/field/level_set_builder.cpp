#include "vdbpack/field/level_set_builder.h"

#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/field/vdb_init.h"

#include <openvdb/tools/Prune.h>

#include <cassert>
#include <utility>

namespace vdbpack {

using openvdb::FloatGrid;
using Node = FloatGrid::TreeType::LeafNodeType;

static_assert(Node::DIM == LevelSetTile::kSide && Node::SIZE == LevelSetTile::kVoxels);

namespace {

openvdb::Coord coordOf(const VoxelIndex& v) {
    return {v[0], v[1], v[2]};
}

}  // namespace

struct LevelSetTile::Leaf {
    std::unique_ptr<Node> node;
};

LevelSetTile::LevelSetTile() = default;
LevelSetTile::LevelSetTile(const VoxelIndex& first, float value)
    : leaf_(std::make_unique<Leaf>(Leaf{std::make_unique<Node>(coordOf(first), value, false)})) {}
LevelSetTile::~LevelSetTile() = default;
LevelSetTile::LevelSetTile(LevelSetTile&&) noexcept = default;
LevelSetTile& LevelSetTile::operator=(LevelSetTile&&) noexcept = default;

float* LevelSetTile::values() {
    return leaf_->node->buffer().data();
}

void LevelSetTile::setActive(const std::bitset<kVoxels>& active) {
    Node::NodeMaskType mask;
    for (std::size_t i = 0; i < kVoxels; ++i)
        if (active[i]) mask.setOn(static_cast<openvdb::Index>(i));
    leaf_->node->setValueMask(mask);
}

struct LevelSetBuilder::Impl {
    float inside;
    FloatGrid::Ptr grid;
};

LevelSetBuilder::LevelSetBuilder(float inside, float outside) {
    initializeOpenVdb();
    impl_ = std::make_unique<Impl>(Impl{inside, FloatGrid::create(outside)});
}
LevelSetBuilder::~LevelSetBuilder() = default;

void LevelSetBuilder::add(LevelSetTile tile) {
    impl_->grid->tree().addLeaf(tile.leaf_->node.release());
}

void LevelSetBuilder::addInside(const VoxelIndex& first, int side) {
    assert(side == LevelSetTile::kSide || side == kLargeSide);
    const openvdb::Index level = side == kLargeSide ? 2 : 1;
    impl_->grid->tree().addTile(level, coordOf(first), -impl_->inside, false);
}

std::shared_ptr<const VdbGrid> LevelSetBuilder::finish(const std::string& name,
                                                       const Vec<3>& origin, double voxelSize) {
    FloatGrid& grid = *impl_->grid;
    openvdb::tools::prune(grid.tree());
    const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
    transform->postTranslate(openvdb::Vec3d(origin[0], origin[1], origin[2]));
    grid.setTransform(transform);
    grid.setName(name);
    grid.setGridClass(openvdb::GRID_LEVEL_SET);
    return std::make_shared<VdbGrid>(std::move(impl_->grid));
}

}  // namespace vdbpack
