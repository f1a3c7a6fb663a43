// Private: level sets with a deeper band.
#pragma once

#include "vdbpack/field/vdb_grid.h"

namespace vdbpack {

/// A level set known `voxels` deeper inside than it was: distances solve the eikonal equation.
openvdb::FloatGrid::Ptr widened(const openvdb::FloatGrid& levelSet, int voxels);

}  // namespace vdbpack
