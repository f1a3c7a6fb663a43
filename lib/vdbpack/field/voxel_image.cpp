#include "vdbpack/field/voxel_image.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

namespace vdbpack {

VoxelImage emptyImage(const Vec<3>& first, const std::array<double, 3>& count, double voxelSize,
                      double rim) {
    double all = 1;
    for (const double n : count) all *= n + 2 * rim;
    if (!(all <= static_cast<double>(kLargestImage)))
        throw ResourceError(
            fmt::format("image of a solid: {:.3g} voxels of {:.4g} mm, more than {:.3g}; give "
                        "larger voxels or smaller bounds",
                        all, voxelSize, static_cast<double>(kLargestImage)));
    VoxelImage image;
    image.voxelSize = voxelSize;
    for (std::size_t j = 0; j < 3; ++j) {
        image.size[j] = static_cast<std::int64_t>(count[j] + 2 * rim);
        image.origin.c[j] = first.c[j] - rim * voxelSize;
    }
    try {
        image.distance.resize(image.voxels());
        if (rim > 0) image.label.assign(image.voxels(), 0);
    } catch (const std::bad_alloc&) {
        throw ResourceError(
            fmt::format("image of a solid: not enough memory for {:.3g} voxels of {:.4g} mm; give "
                        "larger voxels or smaller bounds",
                        all, voxelSize));
    }
    if (!(rim > 0)) return image;
    const auto r = static_cast<std::int64_t>(rim);
    for (std::int64_t z = r; z < image.size[2] - r; ++z)
        for (std::int64_t y = r; y < image.size[1] - r; ++y)
            std::fill_n(image.label.begin() + (z * image.size[1] + y) * image.size[0] + r,
                        image.size[0] - 2 * r, std::uint8_t{1});
    return image;
}

}  // namespace vdbpack
