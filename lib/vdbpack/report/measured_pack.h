// The measures of a pack that every report has.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/report/report.h"

#include <cstddef>
#include <optional>
#include <string>

namespace vdbpack {

/// Measures any pack; its first `report.existing` spheres are those of the input pack. Computes
/// `depth` and `contacts` of the pack.
///
/// Cancelling sets `report.interrupted`. If that is set, only count, hash, radii, overlap,
/// protrusion, solid fraction and, if requested, the gap are measured, and the pack has no depths
/// and no contacts.
/// @param local  what differs by place in `sizes`; null: nothing.
template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report,
                 const Callbacks& callbacks = {}, const LocalSizes* local = nullptr);

/// Sets `report.massOffset` where the spheres fill the domain: no center lies outside, and voids
/// have removed none. A part of `measurePack`, after `report.protrusion`.
/// @param ranks  of whose spheres these are a share; null: they are all.
template <int Dim>
void measureMassOffset(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                       Report& report, Ranks* ranks = nullptr);

/// Warns that solid fractions count overlaps twice, and by how much.
template <int Dim>
void warnOfUnion(const std::string& file, const Pack<Dim>& pack, const Report& report,
                 const Callbacks& callbacks);

/// Depth of the distance field that `measureStructure` needs for such radii, mm: three mean
/// diameters for the pair correlation, and slightly more than the shell.
double structureDepth(const RadiusStatistics& radius, double shell);

/// Compares the radii of a pack with the requested ones; a part of `measurePack`.
/// @param local   what differs by place; null: nothing.
/// @param domain  of that.
template <int Dim>
void measureSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, Report& report,
                  const LocalSizes* local = nullptr, const Domain<Dim>* domain = nullptr);

/// Share of a radius to which the factor of its place is met, with a margin.
inline constexpr double kFactorKnown = 5e-4;
/// A group of sizes by place with its name, before it is measured.
Report::LocalGroup localGroup(const LocalSizes& local, std::uint32_t group,
                              const SizeDistribution& sizes);
/// Adds a group that was measured: the report keeps the distances of the worst group.
void addLocalGroup(Report::LocalGroup group, Report& report);

/// Density profile, local fraction, pair correlation and regions of a pack whose `depth` was set by
/// `measurePack`.
/// @param domain  null: none of these that need a domain.
/// @param shell   thickness of the layer along the wall that is measured separately, mm; 0: none.
/// @param rows    where ranks share the pack: called by all of them.
/// @throws Interrupted
template <int Dim>
Structure measureStructure(const Pack<Dim>& pack, const Domain<Dim>* domain, const Report& report,
                           double shell, const Callbacks& callbacks = {},
                           const SphereRows& rows = {});

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
