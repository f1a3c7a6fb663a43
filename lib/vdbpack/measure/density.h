// Solid fraction of a pack: of the whole domain, of its interior, by depth, and how much it varies.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
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

/// Volume of the union of spheres / sum of their volumes (2D: areas): 1 where none overlap.
///
/// Those that overlap are sampled by 16 to 20,000 low-discrepancy points each, 600,000 together.
/// @param cell  in which they repeat. @throws InputError for an unusable sphere.
template <int Dim>
double unionShare(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell = {});

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

/// Solid fraction against the distance to the wall.
struct DensityProfile {
    double width = 0;              ///< of a bin, mm; the first begins at the wall
    std::vector<double> volume;    ///< of each bin's part of the domain, mm^dim
    std::vector<double> fraction;  ///< of that, covered by spheres
    std::vector<double> error;     ///< standard error of each
};

/// Bins of `width` from the wall down to `deepest`, as far as the domain reaches.
///
/// Spheres are sampled by 16 to 1000 low-discrepancy points each, three million together; the
/// errors are those of as many independent points, which are larger. The volume of each bin is
/// `Domain::volumeDeeperThan`'s.
/// @param deepest  mm, at most `domain.fieldDepth()`.
/// @param rows     where ranks share the pack: called by all of them.
/// @throws ParameterError for other widths and depths; InputError for an unusable sphere.
template <int Dim>
DensityProfile densityProfile(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                              double width, double deepest, const SphereRows& rows = {});

/// Solid fraction in the cells of a coarse grid.
struct LocalFraction {
    double edge = 0;          ///< of a cell, mm
    std::uint64_t cells = 0;  ///< whose circumscribed sphere lies in the domain
    double mean = 0, sd = 0;  ///< over those
};

/// Cubes (2D: squares) laid over the middle of the domain's bounds; those near the wall do not
/// count. Spheres within a cell are taken exactly, others by 32 points each: about 0.001 of the
/// deviation at ten mean radii comes from that.
/// @param rows  where ranks share the pack: called by all of them.
/// @return nothing if no cell counts.
/// @throws ParameterError for an edge that is not positive or gives more than 1e8 cells.
template <int Dim>
std::optional<LocalFraction> localFraction(const std::vector<Sphere<Dim>>& spheres,
                                           const Domain<Dim>& domain, double edge,
                                           const SphereRows& rows = {});

}  // namespace vdbpack
