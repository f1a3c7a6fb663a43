// The bonds of a pack: which spheres are bonded, and their file.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/units.h"

#include <string>
#include <vector>

namespace vdbpack {

/// The pairs of spheres that are bonded, sorted by i, then j.
template <int Dim>
std::vector<Contact> bondedPairs(const Pack<Dim>& pack, const BondOptions& options);

/// Their bonds, sorted by i, then j. @throws as `bondsOf` and `listContacts`; ParameterError for
/// spheres whose modulus is not positive.
std::vector<Bond> bondsIn(const Pack<3>& pack, const BondOptions& options);

/// A .csv with a row for each bond: ids i and j, direction from i to j (nx, ny, nz), length,
/// arm_i, arm_j (from the centers to the middle of the gap), radius, area, modulus, k_n, k_t,
/// k_bending, k_torsion, region_i, region_j, and of packs of several parts part_i and part_j.
/// Forces are in N, lengths in `unit`: moduli in N per unit², k_n in N per unit. Whole or absent.
/// @throws IoError
void writeBonds(const Pack<3>& pack, const std::vector<Bond>& bonds, const std::string& file,
                Unit unit);

}  // namespace vdbpack
