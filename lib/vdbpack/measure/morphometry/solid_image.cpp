#include "vdbpack/measure/morphometry/solid_image.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/measure/morphometry/border.h"

#include <fmt/format.h>

#include <algorithm>

namespace vdbpack {

namespace {

/// An image narrower than this is warned about.
constexpr std::int64_t kFewVoxels = 16;

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

}  // namespace vdbpack
