// Private to verify: spheres of a periodic cell, repeated across its faces.
//
// Independent of core/periodic_cell.h but for the cell's values: an error there must not hide
// itself.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Spheres folded into their cell, then their copies beside it that may overlap one of them.
template <int Dim>
struct RepeatedSpheres {
    std::vector<Sphere<Dim>> spheres;
    std::vector<std::uint32_t> original;  ///< index of each in the caller's array
};

/// @param spheres  usable (`requireVerifiable`).
/// @throws InputError if the cell is shorter than two diameters of the largest sphere.
template <int Dim>
RepeatedSpheres<Dim> repeatedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                     const PeriodicCell<Dim>& cell);

}  // namespace vdbpack
