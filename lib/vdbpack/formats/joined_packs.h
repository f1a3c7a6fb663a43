// Packs with further spheres.
#pragma once

#include "vdbpack/core/pack.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// @throws InputError "file: ..." where ids or orders end so close to 2^63 that none are left for
/// spheres that are added.
template <int Dim>
void requireRoomToNumber(const Pack<Dim>& pack, const std::string& file);

/// Both packs in one: those of `base` first, with all their attributes and columns. Added spheres
/// get further ids, and 0 or nothing in the columns of `base`. The column `existing` marks the
/// spheres of `base`.
template <int Dim>
Pack<Dim> joined(Pack<Dim> base, const Pack<Dim>& added);

/// `base` with further spheres, which get further ids and places in the order, and 0 or nothing in
/// its columns. Depths and contacts of all are dropped.
template <int Dim>
Pack<Dim> appended(Pack<Dim> base, const std::vector<Sphere<Dim>>& added);

/// Adds a pack of a part to those before it, and its number to the first column, `part`. Depths are
/// taken over, contacts are not.
void appendPart(Pack<3>& all, Pack<3> part, std::int32_t number);

}  // namespace vdbpack
