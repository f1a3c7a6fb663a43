// Which spheres of a pack hang together.
#pragma once

#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// 1 for each sphere that contacts join, over any number of others, with one whose region is 0 (the
/// shell); with no regions given, for each of the largest set that contacts join.
/// @param tolerance  as of `countContacts`.
/// @throws as `countContacts`.
template <int Dim>
std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                          const std::vector<std::int32_t>& region,
                                          double tolerance);

}  // namespace vdbpack
