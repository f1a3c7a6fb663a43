// Private to runs: where parts of a pack meet, and what joins them there.
#pragma once

#include "vdbpack/run/run_parts.h"

namespace vdbpack {

/// The pairs in contact of a pack whose spheres are in two parts, by their column `kPartColumn`.
std::uint64_t contactsBetweenParts(const Pack<3>& pack, double tolerance);

/// Warns of moduli in another unit: half of the spheres of a part, or the bonds, have one that no
/// material of bones and implants has, or the modulus of an implant is below that of its bone.
void warnOfModuli(const PackAttributes& pack, const BondLaw& law, const Callbacks& callbacks);

/// Warns of factors and shares of bonds that are lengths or percents.
void warnOfBondLaw(const BondLaw& law, const Callbacks& callbacks);

/// The densities and moduli that the spheres of each part have of their own.
std::vector<MaterialReport> materialsOf(const PackAttributes& pack);

/// Warns of a tolerance between parts where a pack has none and states none, and of a modulus of
/// bonds where all spheres have their own.
void warnOfUnusedBonds(const PackAttributes& pack, const PackOrigin& origin,
                       const BondOptions& options, const Callbacks& callbacks);

/// Warns of the periodic cell, tolerances and the shear ratio of bonds that a .csv does not hold,
/// where no other file of the run does.
void warnOfLostOrigin(const std::vector<OutputTarget>& outputs, const PackOrigin& origin,
                      bool isPeriodic, const Callbacks& callbacks);

/// Warns of parts of a pack that hardly any of its bonds or contacts joins to others.
template <class Pair>
void warnOfLooseParts(const Pack<3>& pack, const std::vector<Pair>& pairs,
                      const Callbacks& callbacks);

/// Lists the interfaces between parts in the report of their joined pack, with their bonds (of
/// `RunSettings::bonds`). Warns, where outputs list pairs or spheres have moduli, of interfaces
/// with fewer than half as many bonds per area as a plane through the weaker of their parts cuts.
void measureInterfaces(const Parts& parts, Run<3>& all);

}  // namespace vdbpack
