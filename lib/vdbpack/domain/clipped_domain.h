// Domains cut by planes.
#pragma once

#include "vdbpack/core/half_space.h"
#include "vdbpack/domain/domain.h"

#include <memory>
#include <vector>

namespace vdbpack {

/// `domain` cut by half-spaces: the points of `domain` inside all of them. Distances inside stay
/// exact; outside, signs are right and distances are to the nearest wall of the parts, a lower
/// bound. Volumes and areas are integrals: of exact chords for shapes (error below 0.05 %), of
/// samples for others (below 0.5 % for meshes in voxels that suit the bone).
/// @param envelope  what `Domain::envelope` is to be; null: the cut domain itself.
/// @throws ParameterError for a zero normal, InputError if nothing is left.
template <int Dim>
std::shared_ptr<const Domain<Dim>> clippedDomain(std::shared_ptr<const Domain<Dim>> domain,
                                                 const std::vector<HalfSpace<Dim>>& planes,
                                                 std::shared_ptr<const Domain<Dim>> envelope = {});

}  // namespace vdbpack
