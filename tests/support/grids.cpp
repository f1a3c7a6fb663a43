#include "support/grids.h"

#include <openvdb/tools/LevelSetSphere.h>

namespace vdbpack::test {

openvdb::FloatGrid::Ptr ballGrid(float radius, const openvdb::Vec3f& center, float voxelSize) {
    openvdb::initialize();
    return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(radius, center, voxelSize);
}

}  // namespace vdbpack::test
