// Private to field and domain: the limit of voxels.
#pragma once

namespace vdbpack {

/// Voxels below this have a volume that OpenVDB takes for zero, mm.
inline constexpr double kSmallestVoxel = 2e-5;

}  // namespace vdbpack
