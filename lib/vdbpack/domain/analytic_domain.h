// Domains given by a formula: box, ball, cylinder, rectangle, disc, with exact distances.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// The inside of a box (2D: rectangle). @throws ParameterError unless finite and not empty.
template <int Dim>
std::shared_ptr<const Domain<Dim>> boxDomain(const Box<Dim>& box);

/// The inside of a box that repeats along the axes that wrap, with walls along the others.
/// @throws ParameterError unless finite and not empty.
template <int Dim>
std::shared_ptr<const Domain<Dim>> periodicDomain(const PeriodicCell<Dim>& cell);

/// The inside of a ball (2D: disc). @throws ParameterError unless the radius (mm) is positive.
template <int Dim>
std::shared_ptr<const Domain<Dim>> ballDomain(double radius, const Vec<Dim>& center = {});

/// A cylinder around the z axis, from -height/2 to height/2.
/// @throws ParameterError unless radius and height (mm) are positive.
std::shared_ptr<const Domain<3>> cylinderDomain(double radius, double height);

}  // namespace vdbpack
