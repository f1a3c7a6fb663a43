// Domains given by a formula: box, ball, cylinder, rectangle, disc, with exact distances.
#pragma once

#include "vdbpack/core/half_space.h"
#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// The inside of a box (2D: rectangle). @throws ParameterError unless finite and not empty.
template <int Dim>
std::shared_ptr<const Domain<Dim>> boxDomain(const Box<Dim>& box);

/// The inside of a ball (2D: disc). @throws ParameterError unless the radius (mm) is positive.
template <int Dim>
std::shared_ptr<const Domain<Dim>> ballDomain(double radius, const Vec<Dim>& center = {});

/// A cylinder about the z axis, from -height/2 to height/2.
/// @throws ParameterError unless radius and height (mm) are positive.
std::shared_ptr<const Domain<3>> cylinderDomain(double radius, double height);

/// `domain` cut by half-spaces: the points of `domain` inside all of them. Distances inside
/// stay exact; outside, the signs are right and distances are to the nearest wall of the parts,
/// a lower bound. Measures are integrals: of exact chords for shapes (error below 0.05 %), of the
/// field for meshes (below 0.5 % in voxels that suit the bone). @throws ParameterError for a zero
/// normal, InputError if nothing is left.
template <int Dim>
std::shared_ptr<const Domain<Dim>> clippedDomain(std::shared_ptr<const Domain<Dim>> domain,
                                                 const std::vector<HalfSpace<Dim>>& planes);

/// The plane z = `height` of a 3D domain, as a domain of the plane (x, y).
/// @throws InputError if the plane misses the domain.
std::shared_ptr<const Domain<2>> sliceDomain(std::shared_ptr<const Domain<3>> domain,
                                             double height);

}  // namespace vdbpack
