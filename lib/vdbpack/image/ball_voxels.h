// Private to image: the voxels whose centers lie in a ball.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/image/image_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

/// A range of slices along the third axis.
struct SliceRange {
    std::size_t begin, end;
};

/// The slices that a ball may have voxels in.
/// @param reach  `ImageGrid::reach`.
inline SliceRange slicesOf(const ImageGrid& grid, const Vec<3>& reach, const Sphere<3>& ball) {
    const double middle = grid.indexOf(ball.center)[2], r = reach[2] * ball.radius;
    const auto end = static_cast<double>(grid.size[2]);
    if (!(middle + r >= 0) || !(middle - r <= end)) return {0, 0};
    return {static_cast<std::size_t>(std::max(0.0, std::ceil(middle - r))),
            static_cast<std::size_t>(std::min(end, std::floor(middle + r) + 1))};
}

/// Calls `visit(number)` for each voxel of some slices whose center lies in a ball.
/// @param visit  takes the place of a voxel among all values.
template <class Visit>
void forEachVoxelIn(const ImageGrid& grid, const Vec<3>& reach, const Sphere<3>& ball,
                    const SliceRange& slices, const Visit& visit) {
    const Vec<3> center = grid.indexOf(ball.center);
    std::size_t low[3] = {0, 0, slices.begin}, high[3] = {0, 0, slices.end};
    for (std::size_t d = 0; d < 2; ++d) {
        const double r = reach.c[d] * ball.radius, x = center.c[d];
        const auto end = static_cast<double>(grid.size[d]);
        if (!(x + r >= 0) || !(x - r <= end)) return;
        low[d] = static_cast<std::size_t>(std::max(0.0, std::ceil(x - r)));
        high[d] = static_cast<std::size_t>(std::min(end, std::floor(x + r) + 1));
    }
    for (std::size_t z = low[2]; z < high[2]; ++z)
        for (std::size_t y = low[1]; y < high[1]; ++y)
            for (std::size_t x = low[0]; x < high[0]; ++x) {
                const Vec<3> at = grid.at(
                    {{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}});
                if (squaredLength(at - ball.center) <= ball.radius * ball.radius)
                    visit((z * grid.size[1] + y) * grid.size[0] + x);
            }
}

}  // namespace vdbpack
