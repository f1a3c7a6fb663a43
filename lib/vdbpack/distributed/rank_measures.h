// Measures of a pack whose spheres several ranks share.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/report/report.h"

#include <cstddef>
#include <vector>

namespace vdbpack {

/// The share of a rank in a pack.
template <int Dim>
struct RankPack {
    Ranks* ranks;
    Pack<Dim>& pack;            ///< its spheres; `depth`, `contacts` and `id` are set
    const Domain<Dim>& domain;  ///< that they fill
    std::size_t fixed;          ///< the first spheres, which were there before
};

/// `measureSizes` for the spheres of all ranks, before any are removed: `depth` of the pack is used
/// where it is set. @param local  what differs by place in `sizes`; null: nothing.
template <int Dim>
void compareSizes(const RankPack<Dim>& share, const SizeDistribution& sizes,
                  const LocalSizes* local, Report& report);

/// `measurePack` for the spheres of all ranks, but for their sizes.
/// @param rows   of the spheres in the pack of all ranks.
/// @param walls  first what the spheres fill, then what encloses it.
/// @return the spheres of any rank that the checks name, the same on all ranks.
template <int Dim>
Pack<Dim> measureOverRanks(const RankPack<Dim>& share, SphereRows rows,
                           const std::vector<const DomainSource*>& walls, double contactTolerance,
                           Report& report);

}  // namespace vdbpack
