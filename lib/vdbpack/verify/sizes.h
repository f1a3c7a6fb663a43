// The radii of a pack: their statistics, and how far they are from a distribution.
#pragma once

#include "vdbpack/core/sphere.h"

#include <functional>
#include <vector>

namespace vdbpack {

struct RadiusStatistics {
    double min = 0, mean = 0, max = 0, sd = 0;  ///< mm; all 0 for an empty pack
};

template <int Dim>
RadiusStatistics radiusStatistics(const std::vector<Sphere<Dim>>& spheres);

/// Kolmogorov-Smirnov distance between radii and a distribution: the largest difference between
/// the share of radii <= r and F(r), over all r.
///
/// @param radii      any order, ascending ones cost no sorting; 0 is returned if there are none.
/// @param cdf        F(r) = P(radius <= r); called from many threads.
/// @param cdfBefore  F(r-) = P(radius < r), where the distribution has atoms; empty: like `cdf`.
/// Radii are taken as known to 1e-6 of their value, so that a radius of a discrete distribution is
/// recognized after a trip through a file of 32-bit floats.
/// @param weightPower  each radius counts r^weightPower: 0 by number, 3 (2D: 2) by volume.
double ksDistance(std::vector<double> radii, const std::function<double(double)>& cdf,
                  const std::function<double(double)>& cdfBefore = {}, int weightPower = 0);

}  // namespace vdbpack
