// Distribution of a length over the voxels of a phase.
#pragma once

#include <vector>

namespace vdbpack {

/// Statistics of the local thickness over the voxels of a phase, mm.
struct LengthStatistics {
    double mean = 0, sd = 0, max = 0;
    /// Of the distribution over voxels, at 0 %, 1 %, ..., 100 %: 101 values, non-decreasing, from
    /// the smallest thickness to `max`. Exact to 1/32 of a voxel, the width of a class of the
    /// histogram that they are from (classes above 32768 voxels are one). Empty: not known.
    std::vector<double> quantiles = {};

    /// At `percent` from 0 to 100; `quantiles` must not be empty.
    double quantile(int percent) const;
};

/// Kolmogorov-Smirnov distance of two distributions, 0 (the same) to 1 (one lies above the other):
/// the largest difference between the shares of voxels up to a length.
///
/// Exact for the distributions that `quantiles` describe if lengths are distributed evenly between
/// neighboring quantiles; equal quantiles are a step. Against all voxels, up to 0.01 is lost within
/// the distance of two quantiles.
/// @throws ParameterError if one of them has no quantiles.
double ksDistance(const LengthStatistics& a, const LengthStatistics& b);

}  // namespace vdbpack
