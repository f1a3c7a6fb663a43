// Packs of about a wanted number of spheres.
#pragma once

#include "vdbpack/pack/packer.h"

#include <functional>
#include <vector>

namespace vdbpack {

/// The spheres of a pack that count toward a target, where later stages remove others.
template <int Dim>
struct CountedSpheres {
    /// How many of the spheres, in a pack whose largest radius is `largest` mm; empty: all. Over
    /// ranks: of the spheres of all ranks, from the spheres of one.
    std::function<double(const std::vector<Sphere<Dim>>& spheres, double largest)> count;
    double share = 1;     ///< of all spheres, estimated
    double fraction = 0;  ///< of the domain that spheres fill, about; 0: found by smaller packs
};

/// A pack of about `target` spheres: `options.sizes` are scaled until so many fill the domain.
///
/// The first scale is `scaleForCount`'s guess from smaller packs, the next scales follow the line
/// through the last two packs (logarithm of the count against logarithm of the scale), kept between
/// scales that gave too few and too many. Within 1.8 % of `target`, or the number itself where that
/// is less than a sphere; where eight packs come no nearer, the nearest is returned with a warning.
/// @param options   its sizes are left as they were packed.
/// @param existing  as for `packSpheres`; not counted.
/// @param counted   which spheres of a pack count.
/// @throws as `packSpheres` and `scaleForCount`.
template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks = {},
                            const std::vector<Sphere<Dim>>& existing = {},
                            const CountedSpheres<Dim>& counted = {});

/// Sets the sizes of `options` (also of the shell) to the sizes of `from` times `factor`, rounded
/// as their texts state them.
void scaleSizes(PackOptions& options, const PackOptions& from, double factor);

}  // namespace vdbpack
