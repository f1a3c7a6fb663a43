// Private: level sets with a deeper or a narrower band, and fog.
#pragma once

#include "vdbpack/field/vdb_grid.h"

namespace vdbpack {

/// A level set known `voxels` deeper inside: the new distances solve the eikonal equation by the
/// fast sweeping method (Zhao 2004, doi:10.1090/S0025-5718-04-01678-3).
openvdb::FloatGrid::Ptr widened(const openvdb::FloatGrid& levelSet, int voxels);

/// A copy of a level set with the band cut to `width` (mm) on both sides.
openvdb::FloatGrid::Ptr narrowed(const openvdb::FloatGrid& levelSet, float width);

/// Turns a level set into fog: 1 deeper than its band, falling to 0 at the wall.
void makeFog(openvdb::FloatGrid& levelSet);

}  // namespace vdbpack
