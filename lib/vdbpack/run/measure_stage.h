// Private to runs: what is measured of a pack.
#pragma once

#include "vdbpack/measure/structure.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/report/report.h"
#include "vdbpack/run/domain_source.h"

namespace vdbpack {

/// Measures any pack; its first `report.existing` spheres are those of the input pack. Once
/// `report.interrupted`, or cancelled (which sets it), only what verifies the pack: overlap,
/// protrusion and, if one was requested, the gap; with count, hash, radii and solid fraction. The
/// pack then has no depths and no contacts.
template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report,
                 const Callbacks& callbacks = {});

/// Depth to which the field must know distances for all that `measureStructure` measures of such
/// radii, mm: three mean diameters for the pair correlation, and a little beyond the shell.
double structureDepth(const RadiusStatistics& radius, double shell);

/// Compares the radii of a pack with the requested ones; a part of `measurePack`.
template <int Dim>
void measureSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, Report& report);

/// Where the spheres lie in the domain and relative to one another; `pack.depth` as `measurePack`
/// leaves it.
/// @param domain  null: only what needs none.
/// @param shell   thickness of the layer along the wall that is measured apart, mm; 0: none.
/// @throws Interrupted
template <int Dim>
Structure measureStructure(const Pack<Dim>& pack, const Domain<Dim>* domain, const Report& report,
                           double shell, const Callbacks& callbacks = {});

}  // namespace vdbpack
