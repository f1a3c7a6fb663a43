// Vacancies of a pack: points where a further sphere would fit.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

template <int Dim>
struct Vacancies {
    double largest = 0;        ///< largest clearance of a sample point to wall and spheres, mm
    Vec<Dim> at;               ///< the point that has it
    std::uint64_t points = 0;  ///< sample points with a clearance of at least `radius`
    double spacing = 0;        ///< edge of the cube (2D: square) of one sample point, mm
};

/// Searches a domain by quasi-random points, each with its clearance to the spheres and to the
/// wall. The largest vacancy may be larger than found by about half the diagonal of `spacing`.
///
/// @param radius        mm, > 0: a point with this clearance could take a sphere of this radius.
/// @param samplePoints  that fall inside the domain, about; > 0.
/// @throws ParameterError for other arguments; InputError for an unusable sphere.
///
/// Cost: about 0.1 microseconds a point on two threads for a full pack.
template <int Dim>
Vacancies<Dim> findVacancies(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                             double radius, std::uint64_t samplePoints = 10'000'000);

}  // namespace vdbpack
