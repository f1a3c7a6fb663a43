#include "vdbpack/measure/morphometry/local_thickness.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/ball_painting.h"
#include "vdbpack/measure/morphometry/ridge.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace vdbpack {

namespace {

/// The mean of the neighbors of its phase that have a thickness; 0 if none has.
float neighborsMean(const VoxelImage& image, const Leftover& at,
                    const std::vector<float>& thickness) {
    const auto& n = image.size;
    const bool solid = image.distance[at.voxel] < 0;
    double sum = 0;
    int count = 0;
    for (std::int64_t z = std::max<std::int64_t>(at.z - 1, 0); z < std::min(at.z + 2, n[2]); ++z)
        for (std::int64_t y = std::max<std::int64_t>(at.y - 1, 0); y < std::min(at.y + 2, n[1]);
             ++y)
            for (std::int64_t x = std::max<std::int64_t>(at.x - 1, 0); x < std::min(at.x + 2, n[0]);
                 ++x) {
                const auto voxel = static_cast<std::size_t>((z * n[1] + y) * n[0] + x);
                if ((image.distance[voxel] < 0) != solid || !(thickness[voxel] > 0)) continue;
                sum += double{thickness[voxel]};
                ++count;
            }
    return count > 0 ? static_cast<float>(sum / count) : 0.0f;
}

void fillLeft(const VoxelImage& image, const Ridge& ridge, std::vector<Leftover> left,
              std::vector<float>& thickness) {
    std::vector<float> value;
    while (!left.empty()) {
        value.assign(left.size(), 0.0f);
        parallelFor(std::size_t{0}, left.size(),
                    [&](std::size_t i) { value[i] = neighborsMean(image, left[i], thickness); });
        std::vector<Leftover> still;
        for (std::size_t i = 0; i < left.size(); ++i) {
            thickness[left[i].voxel] = value[i];
            if (!(value[i] > 0)) still.push_back(left[i]);
        }
        if (still.size() == left.size()) break;
        left.swap(still);
    }
    for (const Leftover& l : left) thickness[l.voxel] = ridge.ownThickness(l.x, l.y, l.z, l.voxel);
}

}  // namespace

void paintThickness(const VoxelImage& image, const SurfaceDistance& surface, Phase phase,
                    std::vector<float>& thickness) {
    const Ridge ridge(image, surface);
    const bool solid = phase == Phase::solid;
    const auto slices = static_cast<std::size_t>(image.size[2]);
    std::vector<std::vector<RidgeBall>> found(slices);
    parallelFor(std::size_t{0}, slices, [&](std::size_t z) {
        ridge.collect(static_cast<std::int64_t>(z), solid, found[z]);
    });
    std::vector<RidgeBall> balls;
    for (const auto& slice : found) balls.insert(balls.end(), slice.begin(), slice.end());
    found.clear();
    const BallPainting painting(image, std::move(balls));
    std::vector<std::vector<Leftover>> missed(painting.tiles());
    parallelFor(std::size_t{0}, painting.tiles(), [&](std::size_t t) {
        missed[t] = painting.paint(t, image, ridge, solid, thickness);
    });
    std::vector<Leftover> left;
    for (const auto& m : missed) left.insert(left.end(), m.begin(), m.end());
    fillLeft(image, ridge, std::move(left), thickness);
}

}  // namespace vdbpack
