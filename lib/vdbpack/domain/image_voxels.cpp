#include "vdbpack/domain/image_voxels.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/domain_image.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vdbpack {

std::vector<std::uint8_t> solidVoxels(const DomainRecipe& recipe, const Image& image) {
    std::vector<std::uint8_t> solid(image.grid.voxels(), 0);
    const auto mark = [&](std::size_t layer, const auto& isSolid) {
        image.visit([&](const auto* numbers) {
            forAll(solid.size(), [&](std::size_t i) {
                solid[i] |= static_cast<std::uint8_t>(
                    isSolid(image.value(numbers[i * image.layers + layer])));
            });
        });
    };
    if (recipe.threshold) {
        mark(0, [&, least = *recipe.threshold->value](double value) { return value >= least; });
        return solid;
    }
    for (const LabelCount& label : selectedPart(recipe, requiredLabels(recipe, image)).labels)
        mark(label.layer, [&](double value) { return value == static_cast<double>(label.value); });
    return solid;
}

Image withRim(const Image& image, std::size_t rim) {
    Image wide = image;
    const auto& size = image.grid.size;
    for (std::size_t d = 0; d < 3; ++d) {
        wide.grid.size[d] = size[d] + 2 * rim;
        wide.grid.origin -= static_cast<double>(rim) * image.grid.step[d];
    }
    const std::size_t voxel = image.layers * bytesOf(image.type);
    wide.bytes = voxelMemory(wide.grid.voxels() * voxel);
    if (!wide.bytes) throw ResourceError("image: not enough memory for a rim of voxels around it");
    const auto nearest = [&](std::size_t at, std::size_t d) {
        return std::clamp(at, rim, size[d] + rim - 1) - rim;
    };
    parallelFor(std::size_t{0}, wide.grid.size[2], [&](std::size_t z) {
        for (std::size_t y = 0; y < wide.grid.size[1]; ++y)
            for (std::size_t x = 0; x < wide.grid.size[0]; ++x) {
                const std::size_t from =
                    (nearest(z, 2) * size[1] + nearest(y, 1)) * size[0] + nearest(x, 0);
                const std::size_t to = (z * wide.grid.size[1] + y) * wide.grid.size[0] + x;
                std::memcpy(wide.bytes.get() + to * voxel, image.bytes.get() + from * voxel, voxel);
            }
    });
    return wide;
}

void takeVoxels(const std::vector<std::uint8_t>& solid, const ImageGrid& grid, VoxelImage& voxels) {
    const ImageIndexer indexer(grid);
    const auto half = static_cast<float>(0.5 * voxels.voxelSize);
    parallelFor(std::int64_t{0}, voxels.size[2], [&](std::int64_t z) {
        for (std::int64_t y = 0; y < voxels.size[1]; ++y)
            for (std::int64_t x = 0; x < voxels.size[0]; ++x) {
                const Vec<3> step{
                    {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}};
                const Vec<3> index = indexer.indexOf(voxels.origin + voxels.voxelSize * step);
                std::size_t from = 0;
                for (std::size_t d = 3; d-- > 0;) {
                    const auto last = static_cast<double>(grid.size[d] - 1);
                    from = from * grid.size[d] +
                           static_cast<std::size_t>(std::clamp(std::round(index.c[d]), 0.0, last));
                }
                float& distance = voxels.distance[static_cast<std::size_t>(
                    (z * voxels.size[1] + y) * voxels.size[0] + x)];
                if ((distance < 0) != (solid[from] != 0))
                    distance = solid[from] != 0 ? -half : half;
            }
    });
}

}  // namespace vdbpack
