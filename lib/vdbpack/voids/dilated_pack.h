// Voids of an open-cell foam: the dilated spheres of a dense pack.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/voids/void_field.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

/// The largest factor on the half-axes of the voids of a foam.
inline constexpr double kMostDilation = 2;

/// A densified pack about the origin. Lengths in mean radii.
template <int Dim>
struct FoamPack {
    std::vector<Sphere<Dim>> spheres;
    Vec<Dim> half;  ///< of the box that it fills, without the layers along its walls
    std::array<bool, Dim> wraps{};  ///< axes along which it repeats

    /// Whether it serves for a box of this half.
    bool fills(const Vec<Dim>& wanted, const std::array<bool, Dim>& wantedWraps) const {
        bool does = wraps == wantedWraps;
        for (int d = 0; d < Dim; ++d)
            does = does && (wraps[static_cast<std::size_t>(d)] ? wanted[d] == half[d]
                                                               : wanted[d] <= half[d]);
        return does;
    }
};

/// Spheres whose radii are distributed as `sizes` are, but for their mean.
/// @param half   of the box to fill at least. The box is somewhat larger, in steps of 6 %, so that
///               nearly equal requests get the same pack.
/// @param wraps  axes along which the pack repeats, and is as long as `half` says.
/// Cost: some 30 microseconds of processor time a sphere.
/// @throws Interrupted, ResourceError; InputError for a cell that is too short
template <int Dim>
FoamPack<Dim> foamPack(const SizeDistribution& sizes, const Vec<Dim>& half, std::uint64_t seed,
                       const Callbacks& callbacks = {}, const std::array<bool, Dim>& wraps = {});

/// How a dense pack becomes voids.
template <int Dim>
struct FoamOptions {
    /// Along this unit vector space is compressed by the mean aspect while the spheres are packed,
    /// so that ellipsoids along it are packed as densely as spheres are; none: it is not.
    std::optional<Vec<Dim>> along;
    double jitter = 0;  ///< largest displacement of a center, in radii of its sphere; 0 to 1
    std::uint64_t seed = 1;
};

/// The direction along which a domain can be compressed for that: in a periodic cell one along its
/// axes alone, since else the compressed cell would not be a box.
template <int Dim>
std::optional<Vec<Dim>> compressible(const std::optional<Vec<Dim>>& along,
                                     const PeriodicCell<Dim>& cell);

/// What `foamVoids` needs around the part of a domain that may have voids, as half of a box in mean
/// radii.
template <int Dim>
Vec<Dim> foamExtent(const VoidRegion<Dim>& region, const VoidShape<Dim>& shape,
                    const FoamOptions<Dim>& options);

/// Ellipsoids at the spheres of a pack about the middle of a domain. They touch; dilated by some
/// percent, they overlap where they touched, and leave a foam with open cells: struts where three
/// or more meet.
///
/// @param pack   of the sizes of `shape`, at least as large as `foamExtent`.
/// @param shape  b and aspect before the dilation. Without `options.along`, the ellipsoids have the
///               volumes of the packed spheres, and overlap or lie apart along their axes.
template <int Dim>
std::vector<Ellipsoid<Dim>> foamVoids(const VoidRegion<Dim>& region, const FoamPack<Dim>& pack,
                                      const VoidShape<Dim>& shape, const FoamOptions<Dim>& options);

/// All half-axes times a factor; without the voids that do not reach deeper than the shell then.
/// @param local  further factors, one a void, 0 where the void is left out; empty: 1.
template <int Dim>
std::vector<Ellipsoid<Dim>> dilated(const VoidRegion<Dim>& region,
                                    std::vector<Ellipsoid<Dim>> voids, double factor,
                                    const std::vector<double>& local = {});

}  // namespace vdbpack
