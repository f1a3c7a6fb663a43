// The wall of any domain as a level set in voxels of a wanted size.
#pragma once

#include "vdbpack/domain/domain.h"

#include <array>
#include <cstddef>
#include <memory>

namespace vdbpack {

class VdbGrid;

/// A domain as narrow-band level set: three voxels on both sides, named `surface`. From the
/// triangles where the domain is a mesh; else (shapes, clipped domains) from the distances that its
/// sampler gives, which outside of edges are lower bounds.
///
/// @param voxelSize  mm.
/// @throws ParameterError unless the voxel size is positive; ResourceError if memory does not
/// suffice.
std::shared_ptr<const VdbGrid> surfaceLevelSet(const Domain<3>& domain, double voxelSize);

/// Center of the voxel (0, 0, 0) of that level set, mm: the middle of the bounds, off by fractions
/// of a voxel without meaning, so that faces made from voxels or whole numbers fall between them.
template <int Dim>
Vec<Dim> fieldOrigin(const Box<Dim>& bounds, double voxelSize) {
    constexpr std::array<double, 3> kOff{0.123, 0.234, 0.345};
    Vec<Dim> origin = bounds.center();
    for (int d = 0; d < Dim; ++d) origin[d] += kOff[static_cast<std::size_t>(d)] * voxelSize;
    return origin;
}

}  // namespace vdbpack
