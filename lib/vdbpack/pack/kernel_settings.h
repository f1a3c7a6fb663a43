// Private to pack: lengths that the kernel derives from a domain and the options of a pack.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/front/front_settings.h"
#include "vdbpack/pack/pack_options.h"

#include <cstddef>

namespace vdbpack {

/// By how much each sphere is grown and the wall moved inwards while packing, mm: half the gap.
inline double shellOf(const PackOptions& options) {
    return 0.5 * options.gap;
}

/// Mean volume (2D: area) of spheres with radii times `scale` and a shell, mm^Dim.
template <int Dim>
double ballWithShell(const SizeDistribution& sizes, double scale, double shell);

/// The power of two of which all centers are whole multiples, mm.
double quantumFor(const SizeDistribution& sizes);

/// The smallest radius of any species, mm.
double leastRadius(const PackOptions& options);

/// What the front works with.
template <int Dim>
FrontSettings<Dim> frontSettings(const Domain<Dim>& domain, const PackOptions& options);

/// Edge of a block, mm.
template <int Dim>
double blockSide(const Domain<Dim>& domain, const PackOptions& options,
                 const FrontSettings<Dim>& settings);

/// Pending radii that a row of blocks holds.
/// @param last  of a block whose pool goes to no other.
std::size_t poolCapacity(const PackOptions& options, bool last);

}  // namespace vdbpack
