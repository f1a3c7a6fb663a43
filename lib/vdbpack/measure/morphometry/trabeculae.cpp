#include "vdbpack/measure/morphometry/trabeculae.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <algorithm>

namespace vdbpack {

std::optional<double> trabecularThickness(const VdbGrid& solid, const Box<3>& box,
                                          const Domain<3>& domain, double shell) {
    const Vec<3> size = box.size();
    double margin = 0.1 * *std::min_element(size.c.begin(), size.c.end());
    // Where the domain ends with the box the sample was cut: that face stops no ball.
    const Box<3> wide = box.grown(margin), bounds = domain.bounds();
    if (!bounds.contains(wide.lo) || !bounds.contains(wide.hi)) margin = 0;
    VoxelImage image = sampleLevelSet(solid, box, 0, margin);
    labelVoxels(image, domain, shell);
    const Morphometry all = measureMorphometry(image);
    const RegionMorphometry* core = nullptr;
    for (const auto& region : all.regions)
        if (region.label == (shell > 0 ? 2 : 1)) core = &region;
    if (core == nullptr || !core->thickness) return std::nullopt;
    return core->thickness->mean;
}

}  // namespace vdbpack
