// Private to runs: densifying a pack, and its results in the report.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/report/report.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

struct DensifySetting {
    double fraction = 0;                      ///< as that of DensifyOptions
    const SizeDistribution* sizes = nullptr;  ///< of what is added; null: sizes of the pack
    double gap = 0;                           ///< mm
    std::uint64_t seed = 1;
    bool mixSizes = false;   ///< as in DensifyOptions
    std::size_t fixed = 0;   ///< the first spheres, which stay where they are
    Ranks* ranks = nullptr;  ///< that share the spheres; null: none do
    std::vector<std::int64_t>* pieces =
        nullptr;                        ///< over ranks: as in PackResult, brought up to date
    const LocalSizes* local = nullptr;  ///< what differs by place in the sizes; null: nothing
};

/// Moves and adds spheres. Those of the pack keep their indices and attributes, except depths and
/// contacts. Sets `report.densified`, and warns if the result differs from the request. If
/// cancelled, sets `report.interrupted`.
/// @throws as densify.
template <int Dim>
void densifyPack(const Domain<Dim>& domain, const DensifySetting& setting, Pack<Dim>& pack,
                 Report& report, const Callbacks& callbacks);

}  // namespace vdbpack
