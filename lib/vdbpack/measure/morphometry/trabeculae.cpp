#include "vdbpack/measure/morphometry/trabeculae.h"

#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/local_thickness.h"
#include "vdbpack/measure/morphometry/phase_tally.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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

std::optional<double> trabecularThickness(const std::function<double(const Vec<2>&)>& voidDistance,
                                          const Domain<2>& domain, const ShellThickness& shell,
                                          const Vec<2>& origin, double voxelSize) {
    // One layer of voxels, which balls are discs in.
    const Box<2> box = domain.bounds().grown(2 * voxelSize);
    Vec<3> first;
    std::array<double, 3> count{1, 1, 1};
    for (int d = 0; d < 2; ++d) {
        const double from = std::ceil((box.lo[d] - origin[d]) / voxelSize);
        first[d] = origin[d] + from * voxelSize;
        count[static_cast<std::size_t>(d)] =
            std::floor((box.hi[d] - origin[d]) / voxelSize) - from + 1;
    }
    VoxelImage image = emptyImage(first, count, voxelSize, 0);
    image.label.assign(image.voxels(), 0);
    const auto inside = domain.sampler(), envelope = domain.envelope().sampler();
    const std::uint8_t core = shell.any() ? 2 : 1;
    for (std::size_t i = 0; i < image.voxels(); ++i) {
        const auto nx = static_cast<std::size_t>(image.size[0]);
        const Vec<2> x{{first[0] + static_cast<double>(i % nx) * voxelSize,
                        first[1] + static_cast<double>(i / nx) * voxelSize}};
        const double outside = inside->signedDistance(x);
        image.distance[i] = static_cast<float>(
            std::clamp(std::max(outside, -voidDistance(x)), -3 * voxelSize, 3 * voxelSize));
        if (outside < 0) image.label[i] = -envelope->signedDistance(x) > shell.at(x) ? core : 1;
    }
    const SurfaceDistance surface = surfaceDistance(image);
    if (surface.points.empty()) return std::nullopt;
    std::vector<float> thickness(image.voxels(), 0.0f);
    paintThickness(image, surface, Phase::solid, thickness);
    const auto phases = tallyPhases(image, thickness);
    if (core >= phases.size()) return std::nullopt;
    const auto lengths = phases[core].solid.statistics(voxelSize);
    return lengths ? std::optional<double>(lengths->mean) : std::nullopt;
}

}  // namespace vdbpack
