// Private to pack: lengths that the kernel derives from a domain and the options of a pack.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/front/front_settings.h"
#include "vdbpack/pack/pack_options.h"
#include "vdbpack/pack/radius_pool.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// By how much each sphere is grown and the wall moved inwards while packing, mm: half the gap.
inline double shellOf(const PackOptions& options) {
    return 0.5 * options.gap;
}

/// The power of two of which all centers are whole multiples, mm; by the finest sizes.
double quantumFor(const PackOptions& options);

/// The smallest radius of any species, anywhere, mm.
double leastRadius(const PackOptions& options);
/// The largest radius of the first species anywhere, mm.
double largestRadius(const PackOptions& options);

/// The lengths of each group of sizes where their factor is 1.
template <int Dim>
std::vector<FrontLengths> frontLengths(const PackOptions& options);

/// What the front works with; where sizes differ by place, the largest radius is the largest of
/// all, and the other lengths are those of the finest sizes.
template <int Dim>
FrontSettings<Dim> frontSettings(const Domain<Dim>& domain, const PackOptions& options);

/// Edge of a block, mm.
template <int Dim>
double blockSide(const Domain<Dim>& domain, const PackOptions& options,
                 const FrontSettings<Dim>& settings);

/// Whether a ball of this radius (mm) lies about one of the points at which `largestBall` samples a
/// domain, by its field.
template <int Dim>
bool holdsBall(const Domain<Dim>& domain, double radius);

/// Pending radii that a chain of blocks holds.
/// @param ahead     spheres that are yet to be placed from this pool, about.
/// @param expected  spheres of the pack, about.
template <int Dim>
std::size_t poolCapacity(const PackOptions& options, double ahead, double expected);

/// A pool for each group of sizes: of radii with the shell, unless they differ by place.
/// @param stream  of random numbers.
std::vector<RadiusPool> radiusPools(const PackOptions& options, std::uint32_t stream);
/// Pending radii of a pool of a group of about `expected` spheres: some of each chain of blocks are
/// never placed, which few spheres would show.
/// @param usual  of large groups.
std::size_t pendingOfGroup(std::size_t usual, double expected);

}  // namespace vdbpack
