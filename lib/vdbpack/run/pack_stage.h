// Private to runs: the field of a pack to come.
#pragma once

#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/recipe.h"

namespace vdbpack {

/// For which radii the field of a pack is made, mm, and about what its sizes are scaled by.
struct FieldRadii {
    double scale = 1, detail = 0, reach = 0;
};
FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source);

}  // namespace vdbpack
