#include "vdbpack/measure/morphometry/trabeculae.h"

#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/local_thickness.h"
#include "vdbpack/measure/morphometry/phase_tally.h"

#include <algorithm>
#include <vector>

namespace vdbpack {

std::optional<double> trabecularThickness(const VdbGrid& solid, const Box<3>& box,
                                          const Domain<3>& domain, const ShellThickness& shell) {
    const Vec<3> size = box.size();
    double margin = 0.1 * *std::min_element(size.c.begin(), size.c.end());
    // Where the domain ends with the box the sample was cut: that face stops no ball.
    const Box<3> wide = box.grown(margin), bounds = domain.bounds();
    if (!bounds.contains(wide.lo) || !bounds.contains(wide.hi)) margin = 0;
    VoxelImage image = sampleLevelSet(solid, box, 0, margin);
    labelVoxels(image, domain, shell);
    const SurfaceDistance surface = surfaceDistance(image);
    if (surface.points.empty()) return std::nullopt;
    std::vector<float> thickness(image.voxels(), 0.0f);
    paintThickness(image, surface, Phase::solid, thickness);
    const auto phases = tallyPhases(image, thickness);
    const std::size_t core = shell.any() ? 2 : 1;
    if (core >= phases.size()) return std::nullopt;
    const auto lengths = phases[core].solid.statistics(image.voxelSize);
    return lengths ? std::optional<double>(lengths->mean) : std::nullopt;
}

}  // namespace vdbpack
