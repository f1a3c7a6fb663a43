// Contact lists: which spheres touch, for bonded models and network analysis.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/measure/contacts.h"

#include <string>
#include <vector>

namespace vdbpack {

/// Writes a table (.csv) with one row per contact and the columns i, j, gap, nx, ny, nz, region_i,
/// region_j, and part_i, part_j of a pack of several parts. Whole or absent, as `writePack`.
///
/// i and j are ids as in the pack's file (indices if the pack has no ids). The normal points from i
/// to j and has length one, or is 0 0 0 if the centers coincide; 2D: nz = 0. Regions are 0 if the
/// pack has none. Numbers are read back as the same doubles.
///
/// @param contacts  as from `listContacts(pack.spheres, ...)`, written in their order.
/// @param file      any name; its prefix and extension are ignored.
/// @param unit      of `gap`, negative where the spheres overlap.
/// @throws ParameterError (a contact between spheres that the pack does not have, or without a
/// finite gap; attributes of the wrong length), IoError
template <int Dim>
void writeContacts(const Pack<Dim>& pack, const std::vector<Contact>& contacts,
                   const std::string& file, Unit unit = Unit::millimeter);

}  // namespace vdbpack
