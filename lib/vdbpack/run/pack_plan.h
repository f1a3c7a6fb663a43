// Private to runs: what is known of a pack before it is made.
#pragma once

#include "vdbpack/run/memory_estimate.h"
#include "vdbpack/run/recipe.h"

namespace vdbpack {

/// For which radii the field of a pack is made, mm, and about what its sizes are scaled by.
struct FieldRadii {
    double scale = 1, detail = 0, reach = 0;
    double share = 1;  ///< of the domain (`Fill::solid`) or of the spheres that voids leave, about
};

struct PackPlan {
    RequestedSizes requested;
    FieldRadii radii;
    Extent extent;  ///< the field, and as many spheres and voids as usually fit into such a domain
};
PackPlan planPack(const PackRecipe& recipe, const DomainSource& source);

}  // namespace vdbpack
