// The largest ball inside a domain.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

namespace vdbpack {

/// Center and radius (mm) of about the largest ball inside a domain; a radius that is not positive
/// if no point inside was found.
///
/// Samples the domain on a grid and goes uphill from the deepest point; a larger ball in a part
/// that the grid misses is not found. Radius exact to 1e-8 of a local maximum.
template <int Dim>
Sphere<Dim> largestBall(const Domain<Dim>& domain);

}  // namespace vdbpack
