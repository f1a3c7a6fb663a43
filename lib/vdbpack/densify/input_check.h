// Private to densify: whether its options are possible, and whether spheres are a pack: free of
// overlap and inside the domain.
//
// verify, which judges the result, shares no code with it.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/domain.h"

#include <cstddef>
#include <vector>

namespace vdbpack {

/// Overlaps and protrusions up to this share of a radius are accepted.
inline constexpr double kAcceptedOverlap = 1e-6;

/// Fractions above this are no packs of spheres: only a single crystal comes close.
template <int Dim>
inline constexpr double kMostFraction = Dim == 3 ? 0.95 : 0.98;

/// @param count, volume  of the spheres, and of the domain in mm^Dim.
/// @throws ParameterError for impossible options; InputError for a domain without volume.
template <int Dim>
void checkOptions(const DensifyOptions& options, std::size_t count, double volume);

/// Whether no two spheres overlap, and all from position `fixed` on lie inside the domain.
/// @throws InputError naming a sphere whose position or radius is not a usable number.
template <int Dim>
bool isAccepted(const std::vector<Sphere<Dim>>& spheres, std::size_t fixed,
                const Domain<Dim>& domain);

}  // namespace vdbpack
