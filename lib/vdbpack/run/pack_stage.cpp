#include "vdbpack/run/pack_stage.h"

#include "vdbpack/run/void_stage.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source) {
    const SizeDistribution& sizes = requested.sizes;
    const int dim = source.dim();
    FieldRadii radii;
    if (requested.targetCount > 0) {
        // Half full is the lowest that is to be expected: the field is deep and fine enough.
        const double guess = source.volume() / (requested.targetCount * sizes.meanBall(dim));
        radii.scale = std::pow((dim == 3 ? 0.58 : 0.8) * guess, 1.0 / dim);
    }
    radii.detail = fieldDetail(sizes.min(), sizes.mean()) * radii.scale;
    radii.reach =
        std::max(sizes.max() * radii.scale * 1.05 + recipe.gap, depthForShell(recipe.voids) / 3);
    return radii;
}

}  // namespace vdbpack
