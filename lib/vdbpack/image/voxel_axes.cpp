#include "vdbpack/image/voxel_axes.h"

#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace vdbpack {

namespace {

/// No solid has a voxel.
constexpr std::size_t kNoSolid = std::numeric_limits<std::size_t>::max();

/// Calls `work(mine, solid, first, last)` for stretches of voxels of a solid along x, by the
/// indices of their ends. `mine` is a list of each thread with an entry for each solid.
/// @param solidOf  from values to solids, or kNoSolid
template <class Entry, class SolidOf, class Work>
void forEachStretch(const Image& image, std::size_t layer, PerThread<std::vector<Entry>>& entries,
                    const SolidOf& solidOf, const Work& work) {
    const auto& size = image.grid.size;
    image.visit([&](const auto* numbers) {
        parallelFor(IndexRange(0, size[1] * size[2], 64), [&](const IndexRange& rows) {
            std::vector<Entry>& mine = entries.local();
            for (std::size_t row = rows.begin(); row < rows.end(); ++row) {
                const auto* const at = numbers + row * size[0] * image.layers + layer;
                for (std::size_t x = 0; x < size[0];) {
                    const std::size_t begin = x, solid = solidOf(image.value(at[x * image.layers]));
                    const auto number = at[x * image.layers];
                    do ++x;
                    while (x < size[0] && (at[x * image.layers] == number ||
                                           solidOf(image.value(at[x * image.layers])) == solid));
                    if (solid == kNoSolid) continue;
                    const Vec<3> first{{static_cast<double>(begin),
                                        static_cast<double>(row % size[1]),
                                        static_cast<double>(row / size[1])}};
                    Vec<3> last = first;
                    last[0] = static_cast<double>(x - 1);
                    work(mine[solid], solid, first, last);
                }
            }
        });
    });
}

/// The extent along three axes.
struct Extents {
    Vec<3> low{{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                std::numeric_limits<double>::infinity()}};
    Vec<3> high = -low;

    void add(const Extents& other) {
        for (int d = 0; d < 3; ++d) {
            low[d] = std::min(low[d], other.low[d]);
            high[d] = std::max(high[d], other.high[d]);
        }
    }
};

/// Sums over stretches of voxels. Indices are whole numbers, so that sums do not depend on their
/// order.
SolidMoments<3> stretchMoments(const Vec<3>& first, const Vec<3>& last) {
    const double n = last[0] - first[0] + 1;
    Vec<3> middle = first;
    middle[0] = 0.5 * (first[0] + last[0]);
    SolidMoments<3> sums;
    sums.add(n, middle);
    sums.second[0].c[0] += n * (n * n - 1) / 12;
    return sums;
}

/// The moments of voxels in the world, from those of their indices.
SolidMoments<3> inWorld(const SolidMoments<3>& indices, const ImageGrid& grid) {
    SolidMoments<3> world;
    world.volume = indices.volume;
    for (int i = 0; i < 3; ++i)
        world.first += indices.first[i] * grid.step[static_cast<std::size_t>(i)];
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            // A voxel has an extent of its own.
            const double own = i == j ? indices.volume / 12 : 0;
            for (int d = 0; d < 3; ++d)
                world.second[static_cast<std::size_t>(d)] +=
                    (indices.second[i].c[j] + own) * grid.step[i][d] * grid.step[j];
        }
    return world;
}

template <class SolidOf>
std::vector<VoxelSolid> solidsOf(const Image& image, std::size_t layer, std::size_t count,
                                 const SolidOf& solidOf) {
    const ImageGrid& grid = image.grid;
    PerThread<std::vector<SolidMoments<3>>> moments(
        [=] { return std::vector<SolidMoments<3>>(count); });
    forEachStretch(image, layer, moments, solidOf,
                   [](SolidMoments<3>& sums, std::size_t, const Vec<3>& first, const Vec<3>& last) {
                       sums.add(stretchMoments(first, last));
                   });
    std::vector<VoxelSolid> solids(count);
    for (std::size_t k = 0; k < count; ++k) {
        SolidMoments<3> all;
        for (const auto& mine : moments) all.add(mine[k]);
        solids[k].voxels = static_cast<std::size_t>(all.volume);
        if (solids[k].voxels > 0) solids[k].axes = inWorld(all, grid).axes(grid.origin);
    }
    PerThread<std::vector<Extents>> extents([=] { return std::vector<Extents>(count); });
    forEachStretch(image, layer, extents, solidOf,
                   [&](Extents& mine, std::size_t solid, const Vec<3>& first, const Vec<3>& last) {
                       for (const Vec<3>& end : {grid.at(first), grid.at(last)}) {
                           Extents point;
                           for (int d = 0; d < 3; ++d)
                               point.low[d] = point.high[d] =
                                   dot(solids[solid].axes.axes[static_cast<std::size_t>(d)], end);
                           mine.add(point);
                       }
                   });
    for (std::size_t k = 0; k < count; ++k) {
        Extents all;
        for (const auto& mine : extents) all.add(mine[k]);
        for (std::size_t d = 0; d < 3 && solids[k].voxels > 0; ++d) {
            double voxel = 0;
            for (const Vec<3>& step : grid.step)
                voxel += std::fabs(dot(solids[k].axes.axes[d], step));
            solids[k].axes.lengths.c[d] = all.high.c[d] - all.low.c[d] + voxel;
        }
    }
    return solids;
}

}  // namespace

std::vector<VoxelSolid> labelSolids(const Image& image, const std::vector<LabelCount>& labels) {
    std::vector<VoxelSolid> all(labels.size());
    for (std::size_t layer = 0; layer < image.layers; ++layer) {
        std::map<double, std::size_t> solids;
        for (std::size_t i = 0; i < labels.size(); ++i)
            if (labels[i].layer == layer) solids[static_cast<double>(labels[i].value)] = i;
        const auto found = solidsOf(image, layer, labels.size(), [&](double value) {
            const auto known = solids.find(value);
            return known == solids.end() ? kNoSolid : known->second;
        });
        for (const auto& [value, i] : solids) all[i] = found[i];
    }
    return all;
}

VoxelSolid solidFrom(const Image& image, double threshold) {
    return solidsOf(image, 0, 1,
                    [=](double value) { return value >= threshold ? std::size_t{0} : kNoSolid; })
        .front();
}

}  // namespace vdbpack
