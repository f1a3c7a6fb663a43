// Which spheres of a pack are removed by voids.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_recipe.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// 1 for each sphere that is kept: its center lies in no void, or (Cull::touch) no part of it does.
/// One lookup per sphere; errors occur only within half a voxel of a void's surface.
template <int Dim>
std::vector<std::uint8_t> spheresOutside(const std::vector<Sphere<Dim>>& spheres,
                                         const StampedVoids<Dim>& voids, Cull cull);

/// 1 for each sphere whose center lies in no void, exactly: by lookup, and by the ellipsoids
/// themselves where the lookup may be wrong.
/// @param voids    the voids that were stamped.
/// @param deep     1 for each sphere that voids may remove.
template <int Dim>
std::vector<std::uint8_t> centersOutside(const std::vector<Sphere<Dim>>& spheres,
                                         const std::vector<Ellipsoid<Dim>>& voids,
                                         const StampedVoids<Dim>& stamped,
                                         const std::vector<std::int32_t>& deep);

/// 1 for each sphere whose center lies deeper than `shell` below the wall of the envelope: by
/// the signed distance field, and by the exact distance to the wall where the field is too coarse
/// to decide.
template <int Dim>
std::vector<std::int32_t> deeperThan(const std::vector<Sphere<Dim>>& spheres,
                                     const Domain<Dim>& domain, const ShellThickness& shell);

/// Removes the spheres with 0 in `keep`, and their attributes, from `pack`. The others keep their
/// `order`, and their ids if there are ids.
template <int Dim>
void keepOnly(Pack<Dim>& pack, const std::vector<std::uint8_t>& keep);

}  // namespace vdbpack
