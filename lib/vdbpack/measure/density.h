// How full a domain is, and whether a place was left empty.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

/// Sum of the sphere volumes / volume of the domain (2D: areas). The spheres are taken to be
/// disjoint and inside. @throws InputError if the domain has no volume.
template <int Dim>
double solidFraction(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain);

/// Share of the part deeper than `depth` that is covered by spheres.
///
/// Spheres wholly deeper count in full. Those that cross the depth are sampled by 16 to 1000
/// low-discrepancy points each, about four million together: standard error below
/// 3e-4 * (spheres that cross / all that count), so about 1e-4 for a pack of 100 radii across.
/// @param depth  mm, >= 0 and at most `domain.fieldDepth()`; three largest radii is the custom.
/// @return nothing if no part of the domain is that deep.
/// @throws ParameterError for another depth; InputError for an unusable sphere.
template <int Dim>
std::optional<double> interiorFraction(const std::vector<Sphere<Dim>>& spheres,
                                       const Domain<Dim>& domain, double depth);

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
/// @throws ParameterError for other widths and depths; InputError for an unusable sphere.
template <int Dim>
DensityProfile densityProfile(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                              double width, double deepest);

/// Solid fraction in the cells of a coarse grid.
struct LocalFraction {
    double edge = 0;          ///< of a cell, mm
    std::uint64_t cells = 0;  ///< whose circumscribed sphere lies in the domain
    double mean = 0, sd = 0;  ///< over those
};

/// Cubes (2D: squares) laid over the middle of the domain's bounds; those near the wall do not
/// count. Spheres within a cell are taken exactly, others by 32 points each: about 0.001 of the
/// deviation at ten mean radii comes from that.
/// @return nothing if no cell counts.
/// @throws ParameterError for an edge that is not positive or gives more than 1e8 cells.
template <int Dim>
std::optional<LocalFraction> localFraction(const std::vector<Sphere<Dim>>& spheres,
                                           const Domain<Dim>& domain, double edge);

template <int Dim>
struct PlaceCheck {
    double largest = 0;        ///< largest clearance of a sample point to wall and spheres, mm
    Vec<Dim> at;               ///< the point that has it
    std::uint64_t places = 0;  ///< sample points with a clearance of at least `radius`
    double spacing = 0;        ///< edge of the cube (2D: square) that a sample point stands for, mm
};

/// Looks for places that are left: quasi-random points all over a domain, each with its clearance
/// to the spheres and to the wall. The true largest place may be larger than found by about half
/// the diagonal of `spacing`.
///
/// @param radius        mm, > 0: a point with this clearance could take a sphere of this radius.
/// @param samplePoints  that fall inside the domain, about; > 0.
/// @throws ParameterError for other arguments; InputError for an unusable sphere.
///
/// Cost: about 0.1 microseconds a point on two threads for a full pack.
template <int Dim>
PlaceCheck<Dim> findPlaces(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                           double radius, std::uint64_t samplePoints = 10'000'000);

}  // namespace vdbpack
