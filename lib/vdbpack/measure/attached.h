// Connected components of a pack.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// 1 for each sphere in a connected component (by contacts) with a sphere of region 0 (the shell)
/// that has at least a thousandth as many spheres as the largest: smaller ones are loose clusters
/// of the shell. Without regions, for each sphere of the largest connected component.
/// @param tolerance  as of `countContacts`.
/// @param cell       in which the spheres repeat, and touch across its faces.
/// @throws as `countContacts`.
template <int Dim>
std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                          const std::vector<std::int32_t>& region, double tolerance,
                                          const PeriodicCell<Dim>& cell = {});

}  // namespace vdbpack
