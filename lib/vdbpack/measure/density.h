// Solid fraction of a pack: of the whole domain, and of its interior.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <optional>
#include <vector>

namespace vdbpack {

/// Sum of the sphere volumes / volume of the domain (2D: areas). The spheres are assumed to be
/// disjoint and inside.
/// @param ranks  of whose spheres these are a share; null: they are all. @throws InputError if the
/// domain has no volume.
template <int Dim>
double solidFraction(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                     Ranks* ranks = nullptr);

/// Share of the part deeper than `depth` that is covered by spheres.
///
/// Spheres entirely deeper count in full. Those that cross the depth are sampled by 16 to 1000
/// low-discrepancy points each, about four million together: standard error below
/// 3e-4 * (spheres that cross / all that count), so about 1e-4 for a pack of 100 radii across.
/// @param depth  mm, >= 0 and at most `domain.fieldDepth()`; usually three largest radii.
/// @param rows   where ranks share the pack: called by all of them.
/// @return nothing if no part of the domain is that deep.
/// @throws ParameterError for another depth; InputError for an unusable sphere.
template <int Dim>
std::optional<double> interiorFraction(const std::vector<Sphere<Dim>>& spheres,
                                       const Domain<Dim>& domain, double depth,
                                       const SphereRows& rows = {});

}  // namespace vdbpack
