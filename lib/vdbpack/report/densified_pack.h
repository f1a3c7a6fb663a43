// Densifying a pack, and its results in the report.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/report/report.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Moves and adds spheres. Those of the pack keep their indices and attributes, except depths and
/// contacts. Sets `report.densified`, and warns if the result differs from the request. If
/// cancelled, sets `report.interrupted`.
/// @param options  without what the pack says: `regions` and `labels`.
/// @param pieces   over ranks: as in PackResult, brought up to date.
/// @throws as densify.
template <int Dim>
void densifyPack(const Domain<Dim>& domain, DensifyOptions options,
                 std::vector<std::int64_t>& pieces, Pack<Dim>& pack, Report& report,
                 const Callbacks& callbacks);

}  // namespace vdbpack
