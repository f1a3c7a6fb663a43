// Private: the OpenVDB grid behind a level set. Costs 5 s to include; only sources may.
#pragma once

#include <openvdb/openvdb.h>

namespace vdbpack {

/// A level set in mm: inside negative, uniform scale, background = half-width x voxel size.
class VdbGrid {
public:
    explicit VdbGrid(openvdb::FloatGrid::Ptr g) : grid(std::move(g)) {}
    openvdb::FloatGrid::Ptr grid;
};

}  // namespace vdbpack
