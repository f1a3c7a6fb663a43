// Which spheres touch.
#pragma once

#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdbpack {

struct ContactCheck {
    std::vector<std::int32_t> counts;  ///< spheres and walls that each sphere touches
    double mean = 0;                   ///< mean of `counts`, the coordination number; 0 if empty
    std::uint64_t pairs = 0;           ///< touching pairs of spheres
    std::uint64_t wallContacts = 0;    ///< spheres that touch the wall
    /// Smallest gap of the touching pairs, mm; infinity if there are none.
    double smallestGap = std::numeric_limits<double>::infinity();
};

/// Counts contacts.
///
/// @param tolerance  two spheres touch if their gap is below this share of the smaller radius
///                   (overlapping ones do), a sphere and the wall if |depth - radius| is at most
///                   this share of its radius; 0 to 1.
/// @param depth      distance of each center to the wall, mm; empty: walls are not counted.
/// @throws ParameterError for another tolerance or number of depths; InputError as `checkOverlap`.
template <int Dim>
ContactCheck countContacts(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                           const std::vector<float>& depth = {});

/// The smallest distance between the surfaces of two spheres, mm; negative if they overlap.
/// Exact, however far apart they are.
///
/// @param standing  pairs among the first `standing` spheres do not count.
/// @return nothing if there is no pair. @throws InputError as `checkOverlap`.
template <int Dim>
std::optional<double> smallestGap(const std::vector<Sphere<Dim>>& spheres,
                                  std::size_t standing = 0);

}  // namespace vdbpack
