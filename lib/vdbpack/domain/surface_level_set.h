// The wall of any domain as a level set in voxels of a given size.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/field/level_set.h"

#include <memory>

namespace vdbpack {

/// A domain as narrow-band level set: three voxels on both sides, named `surface`. From the
/// triangles where the domain is a mesh; else (shapes, clipped domains) from the distances that its
/// sampler returns, which outside of edges are lower bounds. Of a periodic cell it is the box,
/// closed at its faces.
///
/// @param voxelSize  mm.
/// @throws ParameterError unless the voxel size is positive; ResourceError if memory does not
/// suffice.
std::shared_ptr<const VdbGrid> surfaceLevelSet(const Domain<3>& domain, double voxelSize);

}  // namespace vdbpack
