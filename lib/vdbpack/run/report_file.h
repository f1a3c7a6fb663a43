// Reports as files: .json for programs, .html for people.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/run/run.h"

#include <string>

namespace vdbpack {

/// What a page shows of a pack beside its report.
struct PageDetails {
    Structure structure;
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

/// Where the report of a run is written: `settings.reportFile`, or its `interruptedName`; empty if
/// it is.
std::string reportFileOf(const RunSettings& settings, const Report& report);

/// Writes `recipe.reportFile`, if it is set, in the format of its extension. @throws IoError
void writeReport(const RunResult& run, const PageDetails& details, const PackRecipe& recipe);
void writeReport(const RunResult& run, const CarveRecipe& recipe);
void writeReport(const RunResult& run, const DensifyRecipe& recipe);
void writeReport(const RunResult& run, const VoidsRecipe& recipe);
void writeReport(const MeasureResult& result, const MeasureRecipe& recipe);

/// The same; returns the result.
template <class Recipe>
RunResult reported(RunResult result, const Recipe& recipe) {
    writeReport(result, recipe);
    return result;
}

}  // namespace vdbpack
