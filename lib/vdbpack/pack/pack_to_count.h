// Packs of about a wanted number of spheres.
#pragma once

#include "vdbpack/pack/packer.h"

#include <vector>

namespace vdbpack {

/// A pack of about `target` spheres: `options.sizes` are scaled until so many fill the domain.
///
/// The first scale is `scaleForCount`'s guess from smaller packs, the next ones follow the line
/// through the last two packs (logarithm of the count against that of the scale), kept between
/// scales that gave too few and too many. Within 1.8 % of `target`, or 1.5 spheres; where eight
/// packs come no nearer, the nearest is returned with a warning.
/// @param options   its sizes are left as they were packed.
/// @param existing  as for `packSpheres`; not counted.
/// @throws as `packSpheres` and `scaleForCount`.
template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks = {},
                            const std::vector<Sphere<Dim>>& existing = {});

/// The distribution with its radii times `factor`: where it is a formula, exactly what the formula
/// says when it is read again.
SizeDistribution scaledSizes(const SizeDistribution& sizes, double factor, int dim);

}  // namespace vdbpack
