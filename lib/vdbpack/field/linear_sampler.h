// Values of a level set between its voxels.
#pragma once

#include "vdbpack/core/vec.h"

#include <memory>

namespace vdbpack {

class VdbGrid;

/// Linear in each direction between the voxels of a grid; `VdbField::Sampler` is faster where the
/// signed distances of a mesh are looked up. One per thread.
///
/// A plane (Dim = 2) is a grid with values at the third index 0.
template <int Dim>
class LinearSampler {
public:
    /// @param origin   center of the voxel (0, 0, 0), mm.
    /// @param outside  value far from all voxels.
    LinearSampler(const VdbGrid& grid, const Vec<Dim>& origin, double voxelSize, double outside);
    ~LinearSampler();
    double operator()(const Vec<Dim>& x);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace vdbpack
