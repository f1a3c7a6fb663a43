// Bond order: crystalline order of spheres.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Bond order of each sphere: the mean over its bonds of the 13 real spherical
/// harmonics of degree 6 of their directions (2D: cos 6 phi and sin 6 phi), as a unit vector, and
/// its length before normalization, 0 to 1.
///
/// A bond joins spheres whose gap is below 0.8 of the smaller radius (equal spheres: centers
/// closer than 1.4 diameters). Source: Steinhardt, Nelson, Ronchetti (1983),
/// doi:10.1103/PhysRevB.28.784; in the plane Halperin, Nelson (1978).
template <int Dim>
struct BondOrder {
    static constexpr std::size_t kComponents = Dim == 3 ? 13 : 2;

    std::vector<std::array<float, kComponents>> direction;
    std::vector<float> strength;  ///< q6 (2D: the absolute psi6); fcc 0.575, hexagonal 1
};

/// @param cell  in which the spheres repeat: bonds join images, too.
/// @throws InputError as `checkOverlap`.
template <int Dim>
BondOrder<Dim> bondOrder(const std::vector<Sphere<Dim>>& spheres,
                         const PeriodicCell<Dim>& cell = {});

/// Share of the spheres in crystalline order: at least 7 (2D: 4) of their bonds join spheres
/// of nearly the same order, the product of the two unit vectors above 0.7. 0 for no spheres; below
/// 0.01 for packs of many sizes, while equal spheres order along flat walls. Source: ten Wolde,
/// Ruiz-Montero, Frenkel (1996), doi:10.1063/1.471721.
///
/// The same for any number of threads; about 3 microseconds a sphere and thread.
/// @throws InputError as `checkOverlap`.
template <int Dim>
double solidLikeShare(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell = {});

/// The number of such spheres among the first `own`; the others are near them, up to twice
/// `bondReach` of the largest radius at least.
template <int Dim>
std::uint64_t solidLikeOfPart(const std::vector<Sphere<Dim>>& spheres, std::size_t own);
/// The distance of two centers below which a bond may join spheres of at most this radius.
double bondReach(double largest);

}  // namespace vdbpack
