// Private to runs: several runs in one domain.
#pragma once

#include "vdbpack/run/run.h"

#include <functional>
#include <vector>

namespace vdbpack {

/// Packs for each of the recipes, which differ in seed and outputs alone; the domain is made once.
/// Interrupted before the first pack, the result is one without spheres.
/// @param done  receives each result and returns whether to continue.
/// @throws as runPack.
void packEach(const std::vector<PackRecipe>& recipes, const Callbacks& callbacks,
              const std::function<bool(RunResult&&)>& done);

/// Voids for each of the recipes, which differ in seed and outputs alone; the domain is read once.
/// @param done  receives each result and returns whether to continue.
/// @throws as runVoids.
void voidsEach(const std::vector<VoidsRecipe>& recipes, const Callbacks& callbacks,
               const std::function<bool(RunResult&&)>& done);

}  // namespace vdbpack
