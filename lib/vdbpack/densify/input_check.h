// Whether spheres are a pack: free of overlap and inside the domain.
//
// densify's own test; verify, which judges the result, shares no code with it.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstddef>
#include <vector>

namespace vdbpack {

/// Overlaps and protrusions up to this share of a radius are accepted.
inline constexpr double kAcceptedOverlap = 1e-6;

/// Whether no two spheres overlap, and all from position `fixed` on lie inside the domain.
/// @throws InputError naming a sphere whose position or radius is not a usable number.
template <int Dim>
bool isAccepted(const std::vector<Sphere<Dim>>& spheres, std::size_t fixed,
                const Domain<Dim>& domain);

}  // namespace vdbpack
