#include "vdbpack/run/solid_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/measure/morphometry/border.h"
#include "vdbpack/measure/morphometry/sphere_image.h"
#include "vdbpack/run/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// An image narrower than this is warned about.
constexpr std::int64_t kFewVoxels = 16;
/// Voxels beyond a wall: the distances next to it are known on both sides.
constexpr double kWallMargin = 3;
/// Dilation of spheres in mean radii, so that contacts become necks of 0.3 radii; voxels in mean
/// radii, narrow enough for the holes between three spheres; those at which connectivity was found
/// a third too low; and the most voxels that are taken by default.
constexpr double kDilation = 0.05, kSphereVoxel = 1.0 / 6, kCoarseVoxel = 0.25, kManyVoxels = 5e7;

}  // namespace

VoxelImage imageInDomain(const Domain<3>& domain, double shell, double voxelSize,
                         const SolidSampler& sample) {
    const Box<3> bounds = domain.bounds();
    {
        VoxelImage image = sample(bounds, kWallMargin * voxelSize);
        labelVoxels(image, domain, shell, true);
        if (borderShares(image).continued <= 0.5) return image;
    }
    const Vec<3> size = bounds.size();
    const double shortest = *std::min_element(size.c.begin(), size.c.end());
    VoxelImage image = sample(bounds, std::max(0.1 * shortest, kWallMargin * voxelSize));
    labelVoxels(image, domain, shell);
    return image;
}

Morphometry measuredImage(const VoxelImage& image, const std::string& subject,
                          const Callbacks& callbacks) {
    callbacks.stopIfCancelled();
    const auto fewest = *std::min_element(image.size.begin(), image.size.end());
    if (fewest < kFewVoxels)
        callbacks.warn(
            fmt::format("{}: the total volume is {} voxels of {:.3g} mm across; figures "
                        "are coarse: choose a larger domain or a smaller `voxelSize`",
                        subject, fewest, image.voxelSize));
    Morphometry m = measureMorphometry(image);
    // One region is the whole.
    if (m.regions.size() == 1) m.regions.clear();
    if (m.solidFraction == 0) callbacks.warn(subject + ": no solid lies in the total volume");
    return m;
}

SphereMorphometry sphereMorphometry(const std::vector<Sphere<3>>& spheres, const Domain<3>* domain,
                                    double meanRadius, const MeasureRecipe& recipe,
                                    const Callbacks& callbacks) {
    SphereMorphometry result;
    result.dilation = recipe.dilation.value_or(kDilation * meanRadius);
    result.dilationOfMeanRadius = result.dilation / meanRadius;
    Box<3> around;
    for (const Sphere<3>& s : spheres) {
        const Vec<3> reach = Vec<3>{{1, 1, 1}} * (s.radius + result.dilation);
        around.add(s.center - reach);
        around.add(s.center + reach);
    }
    const double volume = (domain ? domain->bounds() : around).volume();
    double voxel = recipe.domain.voxelSize;
    if (!(voxel > 0)) {
        voxel = std::max(kSphereVoxel * meanRadius, std::cbrt(volume / kManyVoxels));
        if (voxel > kCoarseVoxel * meanRadius)
            callbacks.warn(fmt::format(
                "{}: the spheres are measured as a solid in voxels of {:.3g} mm, {:.2g} of the "
                "mean "
                "radius, so that narrow pores and necks are lost. Set `voxelSize` to {:.3g}, or "
                "measure a part of the domain with `clips`",
                recipe.pack, voxel, voxel / meanRadius, kSphereVoxel * meanRadius));
    }
    Extent extent;
    extent.count = static_cast<double>(spheres.size());
    extent.imageVoxels = (domain ? kWalledVoxel : 1) * volume / (voxel * voxel * voxel);
    requireResources(extent, recipe);
    const SolidSampler sample = [&](const Box<3>& bounds, double margin) {
        callbacks.stopIfCancelled();
        return sphereImage(spheres, result.dilation, bounds, voxel, margin);
    };
    result.morphometry = measuredImage(domain ? imageInDomain(*domain, recipe.shell, voxel, sample)
                                              : sample(around, kWallMargin * voxel),
                                       recipe.pack, callbacks);
    return result;
}

}  // namespace vdbpack
