#include "vdbpack/run/pack_plan.h"

#include "vdbpack/run/kept_count.h"
#include "vdbpack/run/label_stage.h"
#include "vdbpack/run/void_stage.h"
#include "vdbpack/voids/shell_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Solid fraction of a front in space and in a plane.
constexpr double kSolidInSpace = 0.65, kSolidInPlane = 0.85;

/// @param ball  mean volume (2D: area) of a sphere, mm^dim.
FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source, double ball) {
    const int dim = source.dim();
    FieldRadii radii;
    if (requested.targetCount > 0) {
        // Half full is the lowest that is to be expected: the field is deep and fine enough.
        const double guess = source.volume() / (requested.targetCount * ball);
        radii.scale = std::pow((dim == 3 ? 0.58 : 0.8) * guess, 1.0 / dim);
    }
    if (!recipe.voids.empty()) {
        Extent e = extentOf(source, requested.least(), requested.largest());
        e.count = requested.targetCount;
        e.voids = planVoids(recipe.voids, e, requested.largest() * radii.scale);
        radii.share = keptShare(recipe.voids, e);
        if (requested.targetCount > 0) radii.scale *= std::pow(radii.share, 1.0 / dim);
    }
    radii.detail = requested.detail() * radii.scale;
    radii.reach = std::max(requested.largest() * radii.scale * 1.05 + recipe.gap,
                           depthForShell(recipe.voids, plannedVoxel(recipe.voids, dim)) / 3);
    return radii;
}

/// About the share of a domain that is shell, if that has sizes of its own; else 0.
double shellShare(const PackRecipe& recipe, const RequestedSizes& requested,
                  const DomainSource& source) {
    if (!requested.shellSizes) return 0;
    const Extent e = extentOf(source, requested.least(), requested.largest());
    const auto [least, most] = shellRange(recipe.voids);
    return e.volume > 0 ? std::min(1.0, 0.5 * (least + most) * e.area / e.volume) : 1;
}

}  // namespace

PackPlan planPack(const PackRecipe& recipe, const DomainSource& source) {
    const int dim = source.dim();
    RequestedSizes requested = requestedSizes(recipe, dim);
    const double each = requested.meanBall(dim, shellShare(recipe, requested, source));
    const FieldRadii radii = fieldRadii(recipe, requested, source, each);
    Extent e = extentOf(source, radii.detail, radii.reach, plannedVoxel(recipe.voids, dim));
    e.searching = requested.targetCount > 0;
    e.densifying = recipe.densify > 0;
    e.solid = recipe.voids.fill == Fill::solid;
    // Spheres with half of the gap around them.
    const double ball = each * std::pow(1 + 0.5 * recipe.gap / requested.sizes.mean(), dim);
    const double filled = e.solid ? e.volume * radii.share : e.volume;
    e.count = e.searching ? requested.targetCount / (e.solid ? 1 : radii.share)
                          : (dim == 3 ? kSolidInSpace : kSolidInPlane) * filled / ball;
    if (recipe.maxCount > 0) e.count = std::min(e.count, static_cast<double>(recipe.maxCount));
    e.voids = planVoids(recipe.voids, e, requested.largest() * radii.scale);
    if (const auto labels = labelGridOf(recipe, {&source}))
        e.labelVoxels = static_cast<double>(labels->voxels());
    return {std::move(requested), radii, e};
}

}  // namespace vdbpack
