// Which spheres of a pack voids remove.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_recipe.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// 1 for each sphere that stays: one whose center lies in no void, or (touch) that does not reach
/// into one. One lookup a sphere; wrong only within half a voxel of a void's surface.
template <int Dim>
std::vector<std::uint8_t> spheresOutside(const std::vector<Sphere<Dim>>& spheres,
                                         const StampedVoids<Dim>& voids, Cull cull);

/// 1 for each sphere whose center lies in no void: by lookup, and by the ellipsoids themselves
/// where that can be wrong. No center that stays lies in any of them.
/// @param voids    those that were stamped.
/// @param deep     1 for each sphere that voids may remove.
template <int Dim>
std::vector<std::uint8_t> centersOutside(const std::vector<Sphere<Dim>>& spheres,
                                         const std::vector<Ellipsoid<Dim>>& voids,
                                         const StampedVoids<Dim>& stamped,
                                         const std::vector<std::int32_t>& deep);

/// 1 for each sphere whose center lies deeper than `shell` mm below the wall: from the field, and
/// from the wall itself where that is close.
template <int Dim>
std::vector<std::int32_t> deeperThan(const std::vector<Sphere<Dim>>& spheres,
                                     const Domain<Dim>& domain, double shell);

/// Removes, in place, the spheres with 0 in `keep` with all that belongs to them. Those that stay
/// keep their `order`, and their id where there are ids.
template <int Dim>
void keepOnly(Pack<Dim>& pack, const std::vector<std::uint8_t>& keep);

/// Threshold (method 4): 1 for each sphere that stays, those of `candidates` whose radius is at
/// most R_max - D (R_max - R_min) and all others. The radii are those of the candidates.
/// @param candidates  nonzero for spheres that may be removed.
/// @param fraction    D, in (0, 1].
template <int Dim>
std::vector<std::uint8_t> removeLargest(const std::vector<Sphere<Dim>>& spheres,
                                        const std::vector<std::int32_t>& candidates,
                                        double fraction);

/// Concentric (method 3): picks one of the candidates still there at random, draws a radius from
/// U[R_min / D, R_max / D] and removes the candidates that meet the ball of that radius about its
/// center, until the share D of them is gone. At most one ball more than needed.
/// Source: the paper's density relation D, with the spheres that meet a ball taken out.
template <int Dim>
std::vector<std::uint8_t> removeAround(const std::vector<Sphere<Dim>>& spheres,
                                       const std::vector<std::int32_t>& candidates, double fraction,
                                       std::uint64_t seed);

}  // namespace vdbpack
