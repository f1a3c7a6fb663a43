#include "vdbpack/domain/label_voxels.h"

#include "vdbpack/core/parallel.h"

#include <algorithm>

namespace vdbpack {

void labelVoxels(VoxelImage& image, const Domain<3>& domain, const ShellThickness& shell,
                 bool walled) {
    if (image.label.empty()) image.label.assign(image.voxels(), 1);
    if (walled) image.depth.assign(image.voxels(), 0.0f);
    const double deepest = 3 * image.voxelSize;
    const auto rows = static_cast<std::size_t>(image.size[1] * image.size[2]);
    const auto row = static_cast<std::size_t>(image.size[0]);
    parallelFor(IndexRange(0, rows), [&](const auto& block) {
        const auto sampler = domain.sampler();
        const auto envelope =
            shell.any() && &domain.envelope() != &domain ? domain.envelope().sampler() : nullptr;
        for (std::size_t r = block.begin(); r < block.end(); ++r)
            for (std::size_t i = 0; i < row; ++i) {
                std::uint8_t& label = image.label[r * row + i];
                if (label == 0 && !walled) continue;
                const std::array<std::size_t, 3> at{i, r % static_cast<std::size_t>(image.size[1]),
                                                    r / static_cast<std::size_t>(image.size[1])};
                Vec<3> x = image.origin;
                for (std::size_t d = 0; d < 3; ++d)
                    x.c[d] += static_cast<double>(at[d]) * image.voxelSize;
                const double depth = -sampler->signedDistance(x);
                if (walled)
                    image.depth[r * row + i] =
                        static_cast<float>(std::clamp(depth, -deepest, deepest));
                if (label == 0) continue;
                const double below = envelope ? -envelope->signedDistance(x) : depth;
                label = depth <= 0 ? 0 : shell.any() && below >= shell.at(x) ? 2 : 1;
            }
    });
}

}  // namespace vdbpack
