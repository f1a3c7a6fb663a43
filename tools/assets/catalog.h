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
    long eulerNumber;  ///< of the body: 2 - 2 x tunnels
};

/// With the voxel sizes of their meshes.
const std::vector<Asset>& assets();

}  // namespace vdbpack
