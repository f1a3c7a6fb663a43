// Warnings of `stiffness`: of packs, domains and bonds that do not belong together.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/progress.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The box around the spheres, mm.
Box<3> boxAround(const Pack<3>& pack);

/// Warns of spheres that reach through a part of the domain only, or, with `beyond`, out of it.
void warnOfOtherEnds(const Pack<3>& pack, const Box<3>& bounds, const std::string& domain,
                     bool isBox, bool beyond, const Callbacks& callbacks);
/// Warns where the boundary holds less of a pack than the wall of its domain would.
/// @param wall  area, mm². @param named  whether a domain was given.
void warnOfFewHeld(const Pack<3>& pack, const std::vector<std::uint8_t>& boundary, double wall,
                   bool named, const Callbacks& callbacks);
/// Warns of a periodic cell other than the one that the file of a pack states.
void warnOfOtherCell(const std::string& file, const PeriodicCell<3>& stated,
                     const PeriodicCell<3>& named, const Callbacks& callbacks);
/// Warns of spheres that nothing holds: no chain of bonds leads from them to the boundary, or,
/// where nothing is held, to most others.
void warnOfLoose(const Pack<3>& pack, const std::vector<Bond>& bonds,
                 const std::vector<std::uint8_t>& boundary, const Callbacks& callbacks);
/// Warns of bonds across the faces of a periodic cell that show another size than the pack's.
void warnOfCellFit(const Pack<3>& pack, const std::vector<Bond>& bonds, const Callbacks& callbacks);

}  // namespace vdbpack
