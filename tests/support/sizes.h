// How well the radii of spheres follow a distribution.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/verify/verify.h"

#include <vector>

namespace vdbpack::test {

template <int Dim>
std::vector<double> radiiOf(const std::vector<Sphere<Dim>>& spheres) {
    std::vector<double> radii;
    for (const auto& s : spheres) radii.push_back(s.radius);
    return radii;
}

/// Kolmogorov-Smirnov distance of radii to a continuous distribution.
inline double ksOf(const std::vector<double>& radii, const SizeDistribution& sizes) {
    return ksDistance(radii, [&](double r) { return sizes.cdf(r); });
}
template <int Dim>
double ksOf(const std::vector<Sphere<Dim>>& spheres, const SizeDistribution& sizes) {
    return ksOf(radiiOf(spheres), sizes);
}

}  // namespace vdbpack::test
