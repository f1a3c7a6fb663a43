// Private: level sets with a deeper or a narrower band.
#pragma once

#include "vdbpack/field/vdb_grid.h"

namespace vdbpack {

/// A level set known `voxels` deeper inside: the new distances solve the eikonal equation by the
/// fast sweeping method (Zhao 2004, doi:10.1090/S0025-5718-04-01678-3).
openvdb::FloatGrid::Ptr widened(const openvdb::FloatGrid& levelSet, int voxels);

/// A copy of a level set with the band cut to `width` (mm) on both sides.
openvdb::FloatGrid::Ptr narrowed(const openvdb::FloatGrid& levelSet, float width);

}  // namespace vdbpack
