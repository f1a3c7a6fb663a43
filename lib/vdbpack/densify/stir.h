// Private to densify: what a front leaves in order is put at random before spheres are relaxed.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Exchanges positions at random among the spheres of a region: DensifyOptions::mixSizes.
/// @param fixed    number of the first spheres, which stay where they are.
/// @param regions  of the spheres; empty: all are in one.
/// @param places   of the spheres; exchanged with their positions.
template <int Dim>
void mixSizes(std::uint64_t seed, std::uint64_t stage, std::size_t fixed,
              const std::vector<std::int32_t>& regions, std::vector<Sphere<Dim>>& spheres,
              std::vector<std::uint32_t>& places);

/// Moves circles at random within the domain: a front leaves equal ones in rows along the wall.
/// @param fixed   number of the first spheres, which stay where they are.
/// @param labels  numbers of the spheres among those of all ranks; empty: their indices.
template <int Dim>
void stir(std::uint64_t seed, const Domain<Dim>& domain, std::size_t fixed,
          const std::vector<std::uint32_t>& labels, std::vector<Sphere<Dim>>& spheres);

}  // namespace vdbpack
