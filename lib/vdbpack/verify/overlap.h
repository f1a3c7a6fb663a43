// Overlaps of the spheres of a pack.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// Overlaps and protrusions above this share of a radius are counted.
inline constexpr double kVerifyTolerance = 1e-6;
/// How many of the worst pairs and spheres are named.
inline constexpr std::size_t kWorstNamed = 10;

struct OverlapPair {
    std::size_t i = 0, j = 0;  ///< indices into the pack, i < j
    double overlap = 0;        ///< share of the smaller radius
};

struct OverlapCheck {
    double max = 0;           ///< largest (r_i + r_j - distance) / min(r_i, r_j); 0 without overlap
    std::uint64_t pairs = 0;  ///< pairs above `kVerifyTolerance`
    bool complete = true;     ///< false: counting stopped early, `pairs` is a lower bound
    std::vector<OverlapPair> worst;  ///< up to `kWorstNamed` of them, by falling overlap
};

/// All overlaps of a pack, found in cells and computed in double; any mix of sizes.
///
/// Cost: about 0.2 microseconds a sphere on two threads. Counting stops at 200 pairs a sphere.
/// @param own  the first so many are a part of a pack, the others those of other parts near them:
///             each pair of two parts counts in one of them. By default there is one part.
/// @throws InputError naming a sphere whose position or radius is not a usable number.
template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres,
                          std::size_t own = std::numeric_limits<std::size_t>::max());

/// The same in a periodic cell: images count, each pair once.
/// @throws InputError also if the cell is shorter than two diameters of the largest sphere.
template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell);

}  // namespace vdbpack
