// What a page shows of a pack beside its report.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/report/report.h"

#include <cstddef>
#include <optional>

namespace vdbpack {

/// The radii of the spheres after the first `existing`, which are not this run's choice.
/// @param sizes  the requested ones; null: none. @param ranks  that share the pack; null: none do.
template <int Dim>
RadiusHistogram radiiOf(const Pack<Dim>& pack, std::size_t existing, const SizeDistribution* sizes,
                        Ranks* ranks = nullptr);

/// What a page shows of a pack beside its report.
struct PageDetails {
    std::optional<Structure> structure;
    RadiusHistogram radii;
};

/// Measures a pack for its page. Where the field of `domain` is too shallow for that, another is
/// made, so that the pack does not depend on how it is reported.
/// @param fixed  the first spheres of `pack` come from an input pack.
/// @param sizes  the requested sizes; `pack` and `report` were set by `measurePack`.
/// @param around  whose envelope the shell follows, where `source` is what voids have left of it;
///                null: the envelope of `source`.
/// @param rows   where ranks share the pack: called by all of them.
/// @throws Interrupted
template <int Dim>
PageDetails pageDetails(const Pack<Dim>& pack, std::size_t fixed, const DomainSource& source,
                        const DomainSource* around, const Domain<Dim>& domain,
                        const SizeDistribution& sizes, const Report& report,
                        const Callbacks& callbacks, const SphereRows& rows = {});

}  // namespace vdbpack
