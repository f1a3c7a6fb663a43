// Private to runs: what the stages of `pack` do otherwise where several ranks share the spheres.
#pragma once

#include "vdbpack/run/recipe.h"
#include "vdbpack/run/stages.h"

namespace vdbpack {

/// Refuses what is not done over ranks. @throws ParameterError
void checkRanks(const PackRecipe& recipe);
/// The same in a periodic cell; any other domain passes.
void checkRanksIn(const DomainSource& source, const PackRecipe& recipe);

/// The rows of the spheres, of a run over ranks, by its spans.
template <int Dim>
SphereRows rowsOf(const Run<Dim>& run);

}  // namespace vdbpack
