#include "vdbpack/measure/morphometry/border.h"

#include "vdbpack/core/parallel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

namespace {

struct FaceCount {
    std::uint64_t all = 0, solid = 0, continued = 0;
};

/// The faces at which the total volume ends, seen from its voxels of one slice.
FaceCount facesOfSlice(const VoxelImage& image, std::int64_t z) {
    const auto& n = image.size;
    const std::array<std::int64_t, 3> stride{1, n[0], n[0] * n[1]};
    const auto solid = [&](std::int64_t voxel) {
        return image.distance[static_cast<std::size_t>(voxel)] < 0;
    };
    FaceCount count;
    for (std::int64_t y = 0; y < n[1]; ++y)
        for (std::int64_t x = 0; x < n[0]; ++x) {
            const std::int64_t voxel = x + y * stride[1] + z * stride[2];
            if (!image.inTotal(static_cast<std::size_t>(voxel))) continue;
            const std::array<std::int64_t, 3> at{x, y, z};
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (const int side : {-1, 1}) {
                    const std::int64_t next = at[axis] + side, then = next + side;
                    const bool beyond = next < 0 || next >= n[axis];
                    if (!beyond &&
                        image.inTotal(static_cast<std::size_t>(voxel + side * stride[axis])))
                        continue;
                    ++count.all;
                    if (!solid(voxel)) continue;
                    ++count.solid;
                    if (then >= 0 && then < n[axis] && solid(voxel + side * stride[axis]) &&
                        solid(voxel + 2 * side * stride[axis]))
                        ++count.continued;
                }
        }
    return count;
}

}  // namespace

BorderShares borderShares(const VoxelImage& image) {
    const auto slices = static_cast<std::size_t>(image.size[2]);
    std::vector<FaceCount> counts(slices);
    parallelFor(std::size_t{0}, slices, [&](std::size_t z) {
        counts[z] = facesOfSlice(image, static_cast<std::int64_t>(z));
    });
    FaceCount sum;
    for (const FaceCount& c : counts) {
        sum.all += c.all;
        sum.solid += c.solid;
        sum.continued += c.continued;
    }
    const auto share = [](std::uint64_t part, std::uint64_t all) {
        return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0;
    };
    BorderShares shares;
    shares.solid = share(sum.solid, sum.all);
    shares.continued = share(sum.continued, sum.solid);
    return shares;
}

}  // namespace vdbpack
