// All bundled meshes.
#pragma once

#include "sculpture.h"

#include <string>
#include <vector>

namespace vdbpack {

struct Asset {
    std::string name;
    std::string what;  ///< one line for the file's header
    Sculpture (*sculpt)();
    double voxelSize;  ///< mm
    long eulerNumber;  ///< the body's own: 2 - 2 x tunnels
};

/// Each with the voxel size its mesh is made at.
const std::vector<Asset>& assets();

}  // namespace vdbpack
