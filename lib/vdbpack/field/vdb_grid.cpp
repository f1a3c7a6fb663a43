#include "vdbpack/field/vdb_grid.h"

template class openvdb::Grid<openvdb::FloatTree>;
template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
template class openvdb::tree::LeafManager<openvdb::FloatTree>;
