// Private: the OpenVDB grid behind a level set. Costs 4 s to include; only sources may.
#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>

// OpenVDB's library does not instantiate these classes for its users. Each source that names a grid
// of floats would compile all of their virtual functions: 8 s. vdb_grid.cpp does it for all.
extern template class openvdb::Grid<openvdb::FloatTree>;
extern template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
extern template class openvdb::tree::LeafManager<openvdb::FloatTree>;

namespace vdbpack {

/// A level set in mm: inside negative, uniform scale, background = half-width x voxel size.
class VdbGrid {
public:
    explicit VdbGrid(openvdb::FloatGrid::Ptr g) : grid(std::move(g)) {}
    openvdb::FloatGrid::Ptr grid;
};

}  // namespace vdbpack
