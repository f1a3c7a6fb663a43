// Private to pack: existing spheres without those that no new sphere can touch.
#pragma once

#include "vdbpack/core/sphere.h"

#include <vector>

namespace vdbpack {

/// Leaves out spheres that are hidden by others: wherever a sphere of radius `least` or more keeps
/// clear of those that are returned, it keeps clear of all. The order stays.
///
/// A sphere grown by `least` that lies within the union of others so grown adds nothing to where
/// centers may not be. Some that do are kept: a part of it (a cone of some 10 degrees from its
/// center) must lie within one other.
///
/// @param least  mm, positive.
/// @throws InputError naming one that lies in more of the others than can be told apart (copies
/// are left out, but thousands of spheres around one point are no pack), or as `requireUsable`.
/// Cost: about a microsecond a sphere.
template <int Dim>
std::vector<Sphere<Dim>> exposedSpheres(std::vector<Sphere<Dim>> spheres, double least);

}  // namespace vdbpack
