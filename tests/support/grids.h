// Grids that tests write.
#pragma once

#include "vdbpack/field/vdb_grid.h"

namespace vdbpack::test {

/// An empty grid, made by OpenVDB's registry of types: `GridType::create()` would compile all
/// virtual functions of its tree, which takes 10 s for each type and source.
template <class GridType>
typename GridType::Ptr newGrid(const typename GridType::ValueType& background =
                                   openvdb::zeroVal<typename GridType::ValueType>()) {
    openvdb::initialize();
    const auto grid =
        openvdb::gridPtrCast<GridType>(openvdb::GridBase::createGrid(GridType::gridType()));
    grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
    return grid;
}

/// The level set of a ball, three voxels wide on both sides.
openvdb::FloatGrid::Ptr ballGrid(float radius, const openvdb::Vec3f& center, float voxelSize);

}  // namespace vdbpack::test
