// Depths of the spheres of a pack.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <vector>

namespace vdbpack {

/// Distance of each center to the wall, mm; 0 for centers that the domain calls outside. Exact to
/// float.
///
/// @param toPieces  distance of each center to the triangles (2D: segments) of the wall, mm, as
///                  `checkProtrusion` gives them; empty: the domain is a formula, whose own
///                  distances are exact.
/// @param clips     further planes that cut a domain with such a wall.
template <int Dim>
std::vector<float> centerDepths(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                                const std::vector<double>& toPieces,
                                const std::vector<HalfSpace<Dim>>& clips);

}  // namespace vdbpack
