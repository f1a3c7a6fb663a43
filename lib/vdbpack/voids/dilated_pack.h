// Voids of an open-cell foam: the dilated spheres of a dense pack.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/voids/void_field.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

/// How a dense pack becomes voids.
template <int Dim>
struct FoamOptions {
    /// Along this unit vector space is compressed by the mean aspect while the spheres are packed,
    /// so that ellipsoids along it are packed as densely as spheres are; none: it is not.
    std::optional<Vec<Dim>> along;
    double jitter = 0;  ///< largest displacement of a center, in radii of its sphere; 0 to 1
    std::uint64_t seed = 1;
};

/// Ellipsoids at the spheres of a densified pack around the part of a domain that may have voids.
/// They touch; dilated by some percent, they overlap where they touched, and leave a foam with open
/// cells: struts where three or more meet.
///
/// @param shape  b and aspect before the dilation. Without `options.along`, the ellipsoids have the
///               volumes of the packed spheres, and overlap or lie apart along their axes.
/// Cost: some 30 microseconds of processor time a void. @throws Interrupted
template <int Dim>
std::vector<Ellipsoid<Dim>> foamVoids(const VoidRegion<Dim>& region, const VoidShape<Dim>& shape,
                                      const FoamOptions<Dim>& options,
                                      const Callbacks& callbacks = {});

/// All half-axes times a factor; without the voids that do not reach deeper than the shell then.
/// @param local  further factors, one a void, 0 where the void is left out; empty: 1.
template <int Dim>
std::vector<Ellipsoid<Dim>> dilated(const VoidRegion<Dim>& region,
                                    std::vector<Ellipsoid<Dim>> voids, double factor,
                                    const std::vector<double>& local = {});

}  // namespace vdbpack
