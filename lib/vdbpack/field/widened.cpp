#include "vdbpack/field/widened.h"

#include <openvdb/tools/FastSweeping.h>

namespace vdbpack {

openvdb::FloatGrid::Ptr widened(const openvdb::FloatGrid& levelSet, int voxels) {
    return openvdb::tools::dilateSdf(levelSet, voxels, openvdb::tools::NN_FACE, 1,
                                     openvdb::tools::FastSweepingDomain::SWEEP_LESS_THAN_ISOVALUE);
}

}  // namespace vdbpack
