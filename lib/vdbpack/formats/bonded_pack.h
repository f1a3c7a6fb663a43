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
/// k_bending, k_torsion, tensile and shear (the forces at which it breaks; 0: none), class,
/// region_i, region_j, and of packs of several parts part_i and part_j.
/// Forces are in N, lengths in `unit`: moduli in N per unit², k_n in N per unit. Whole or absent.
/// @throws IoError
void writeBonds(const Pack<3>& pack, const std::vector<Bond>& bonds, const std::string& file,
                Unit unit);

/// Refuses coefficients of a single class. @throws ParameterError
void checkBondClasses(const std::string& output, const BondOptions& options);

/// Commands for LAMMPS that give the bonds of `lammps-bonds:FILE` their stiffness: where each has
/// a class of its own (`options.classes` 0), `bond_style harmonic` with its length; else
/// `bond_style bpm/rotational` with the means of the classes. Whole or absent.
/// @throws ParameterError for a single class; IoError
void writeBondCoefficients(const std::vector<Bond>& bonds, const BondOptions& options,
                           const std::string& file, Unit unit);

/// A .csv with a row for each interface: part_a, part_b, bonds, area, bonds_per_area,
/// bonds_per_area_a, bonds_per_area_b (of a plane through each part); areas in `unit`². Whole or
/// absent. @throws IoError
void writeInterfaces(const std::vector<InterfaceReport>& interfaces, const std::string& file,
                     Unit unit);

}  // namespace vdbpack
