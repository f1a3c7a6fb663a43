// Private to runs: the sizes and the field of a pack to come, and packing to a count.
#pragma once

#include "vdbpack/pack/packer.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/recipe.h"

#include <vector>

namespace vdbpack {

/// For which radii the field of a pack is made, mm, and about what its sizes are scaled by.
struct FieldRadii {
    double scale = 1, detail = 0, reach = 0;
};
FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source);

/// Scales the radii until about `target` spheres fill the domain: a guess from smaller packs, then
/// along the line through the two last packs, count against scale, between what was too few and
/// too many. `options.sizes` is left as packed.
template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing);

}  // namespace vdbpack
