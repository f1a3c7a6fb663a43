// Private to densify: spheres at random places, from which a pack is relaxed without a front.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/densify/densify.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Spheres of a total volume (2D: area) of at least `volume` mm^Dim at random points of a domain,
/// spread evenly over it. They overlap one another and the wall.
/// @param sizes   mm; the radii follow them as evenly as can be.
/// @param margin  least distance of their centers from the wall, beside a share of their radii, mm.
/// @throws InputError where the largest radius has no room; ResourceError above 2e9 spheres.
template <int Dim>
std::vector<Sphere<Dim>> randomStart(const Domain<Dim>& domain, const SizeDistribution& sizes,
                                     double volume, double margin, std::uint64_t seed);

/// Radii as such spheres have, for want of themselves, mm.
std::vector<double> someRadii(const SizeDistribution& sizes);
/// About how many make a solid fraction, or the largest there is.
template <int Dim>
std::uint64_t aboutCount(const SizeDistribution& sizes, double fraction, double volume);
/// About the solid fraction that a front would have: from there on, denser packs take longer.
template <int Dim>
double likeFront(const Domain<Dim>& domain, const DensifyOptions& options);

}  // namespace vdbpack
