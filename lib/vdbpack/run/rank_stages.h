// Private to runs: what the stages of `pack` do otherwise where several ranks share the spheres.
#pragma once

#include "vdbpack/run/recipe.h"
#include "vdbpack/run/stages.h"

#include <string>
#include <vector>

namespace vdbpack {

/// Refuses what is not done over ranks. @throws ParameterError
void checkRanks(const PackRecipe& recipe);
/// The same in a periodic cell; any other domain passes.
void checkRanksIn(const DomainSource& source, const PackRecipe& recipe);

/// measureSizes for the spheres of all ranks, before any are removed: `depth` of the pack is used
/// where it is set.
template <int Dim>
void compareSizes(Run<Dim>& run);

/// measureStage for the spheres of all ranks, with what is found on each of them.
template <int Dim>
void measureOverRanks(Run<Dim>& run);

/// The rows of the spheres, as `measureOverRanks` found them.
template <int Dim>
SphereRows rowsOf(const Run<Dim>& run);

/// Writes outputs of the spheres of all ranks. @return the files, on each of them.
/// @throws ParameterError, IoError
template <int Dim>
std::vector<std::string> writeOverRanks(const std::vector<OutputTarget>& outputs,
                                        const RunOutputs<Dim>& have, const Run<Dim>& run);

}  // namespace vdbpack
