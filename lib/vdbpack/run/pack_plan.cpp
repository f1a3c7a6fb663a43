#include "vdbpack/run/pack_plan.h"

#include "vdbpack/run/kept_count.h"
#include "vdbpack/run/label_stage.h"
#include "vdbpack/run/void_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Solid fraction of a front in space and in a plane.
constexpr double kSolid = 0.65, kSolidInPlane = 0.85;

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
    if (!recipe.voids.empty()) {
        Extent e = extentOf(source, sizes.min(), sizes.max());
        e.count = requested.targetCount;
        e.voids = planVoids(recipe.voids, e, sizes.max() * radii.scale);
        radii.share = keptShare(recipe.voids, e);
        if (requested.targetCount > 0) radii.scale *= std::pow(radii.share, 1.0 / dim);
    }
    radii.detail = fieldDetail(sizes.min(), sizes.mean()) * radii.scale;
    radii.reach = std::max(sizes.max() * radii.scale * 1.05 + recipe.gap,
                           depthForShell(recipe.voids, plannedVoxel(recipe.voids, dim)) / 3);
    return radii;
}

}  // namespace

PackPlan planPack(const PackRecipe& recipe, const DomainSource& source) {
    const int dim = source.dim();
    RequestedSizes requested = requestedSizes(recipe, dim);
    const FieldRadii radii = fieldRadii(recipe, requested, source);
    Extent e = extentOf(source, radii.detail, radii.reach, plannedVoxel(recipe.voids, dim));
    e.searching = requested.targetCount > 0;
    e.densifying = recipe.densify > 0;
    e.solid = recipe.voids.fill == Fill::solid;
    // Spheres with half of the gap around them.
    const double ball = requested.sizes.meanBall(dim) *
                        std::pow(1 + 0.5 * recipe.gap / requested.sizes.mean(), dim);
    const double filled = e.solid ? e.volume * radii.share : e.volume;
    e.count = e.searching ? requested.targetCount / (e.solid ? 1 : radii.share)
                          : (dim == 3 ? kSolid : kSolidInPlane) * filled / ball;
    if (recipe.maxCount > 0) e.count = std::min(e.count, static_cast<double>(recipe.maxCount));
    e.voids = planVoids(recipe.voids, e, requested.sizes.max() * radii.scale);
    if (const auto labels = labelGridOf(recipe, {&source}))
        e.labelVoxels = static_cast<double>(labels->voxels());
    return {std::move(requested), radii, e};
}

}  // namespace vdbpack
