// Solid fraction by distance to the wall.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <vector>

namespace vdbpack {

/// Solid fraction against the distance to the wall.
struct DensityProfile {
    double width = 0;              ///< of a bin, mm; the first begins at the wall
    std::vector<double> volume;    ///< of each bin's part of the domain, mm^dim
    std::vector<double> fraction;  ///< of that, covered by spheres
    std::vector<double> error;     ///< standard error of each
};

/// Bins of `width` from the wall down to `deepest`, as far as the domain reaches.
///
/// Spheres are sampled by 16 to 1000 low-discrepancy points each, twelve million together; the
/// errors are those of as many independent points, which are larger. The volume of each bin is
/// `Domain::volumeDeeperThan`'s.
/// @param deepest  mm, at most `domain.fieldDepth()`.
/// @param rows     where ranks share the pack: called by all of them.
/// @throws ParameterError for other widths and depths; InputError for an unusable sphere.
template <int Dim>
DensityProfile densityProfile(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                              double width, double deepest, const SphereRows& rows = {});

}  // namespace vdbpack
