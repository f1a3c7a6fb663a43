// Private to runs: the domains of a run on several parts.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/options/recipes.h"

#include <memory>
#include <vector>

namespace vdbpack {

/// A part before it is packed.
struct Part {
    PackRecipe recipe;  ///< with its name
    std::shared_ptr<DomainSource> source;
};
using Parts = std::vector<Part>;

/// The parts of a recipe, with surfaces that later ones cut from earlier ones; none if it has one
/// domain. @throws as `runPack`
Parts partsOf(const PackRecipe& recipe, const Callbacks& callbacks);

}  // namespace vdbpack
