// Thinning: removes spheres of a pack without any void.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Threshold (method 4): 1 for each sphere that is kept. Of the candidates, with radii from R_min
/// to R_max, those larger than R_max - D (R_max - R_min) are removed.
/// @param candidates  nonzero for spheres that may be removed.
/// @param fraction    the density relation D, in (0, 1].
/// @throws ParameterError if `fraction` is out of range.
template <int Dim>
std::vector<std::uint8_t> removeLargest(const std::vector<Sphere<Dim>>& spheres,
                                        const std::vector<std::int32_t>& candidates,
                                        double fraction);

/// Concentric (method 3): 1 for each sphere that is kept. Repeatedly picks one of the remaining
/// candidates at random, draws a radius from U[R_min / D, R_max / D] and removes the candidates
/// that meet the ball of that radius about its center, until the share D of them is removed. The
/// last ball may exceed that share.
/// Source: the density relation D of the paper; here all spheres that meet a ball are removed.
/// @param candidates, fraction  as above.
/// @param cell  in which the spheres repeat: balls reach across its faces.
/// @throws ParameterError as above; ResourceError for 2^32 - 1 spheres or more.
template <int Dim>
std::vector<std::uint8_t> removeAround(const std::vector<Sphere<Dim>>& spheres,
                                       const std::vector<std::int32_t>& candidates, double fraction,
                                       std::uint64_t seed, const PeriodicCell<Dim>& cell = {});

}  // namespace vdbpack
