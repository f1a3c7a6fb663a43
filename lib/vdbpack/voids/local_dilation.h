// Factors on the voids of a foam at which BV/TV varies in space as wanted.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_field.h"

#include <functional>
#include <vector>

namespace vdbpack {

/// The factor on the half-axes of each void at which the voids leave BV/TV `wanted`, for `dilated`;
/// 0 for voids that are to be left out, where BV/TV is nearly 1.
///
/// First the relation between BV/TV and a factor on all voids is measured, in a cube of a few mean
/// cells. Each void gets the factor for BV/TV at its center. Then, three times, the voids are
/// stamped, BV/TV is measured by points in windows of three mean cells, and the factors of the
/// voids in the middle of each window are moved by what the relation says about the difference.
///
/// @param voids   before the dilation; they fill the box around the domain.
/// @param wanted  BV/TV by place, from 0 to 1; changes within the length of a cell are smoothed.
///                The mean is met to about 0.01: what follows may scale all factors.
/// @param stamp   how the voids will be stamped.
/// Cost: at most that of stamping the voids five times; in fine voxels less than once, as BV/TV is
/// measured in coarser ones. The same for any number of threads.
/// @throws Interrupted, and as `stampVoids`
template <int Dim>
std::vector<double> localDilation(const VoidRegion<Dim>& region,
                                  const std::vector<Ellipsoid<Dim>>& voids,
                                  const std::function<double(const Vec<Dim>&)>& wanted,
                                  const StampOptions<Dim>& stamp, const Callbacks& callbacks = {});

}  // namespace vdbpack
