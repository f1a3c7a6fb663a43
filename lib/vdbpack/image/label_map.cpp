#include "vdbpack/image/label_map.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/image/ball_voxels.h"

#include <fmt/format.h>

#include <cmath>
#include <new>

namespace vdbpack {

namespace {

/// Slices that one task labels.
constexpr std::size_t kSlab = 8;

LabelMap emptyMap(const ImageGrid& grid) {
    LabelMap map;
    map.grid = grid;
    try {
        map.labels.resize(grid.voxels());
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "a label map of {} x {} x {} voxels takes {}, more than there is; make voxels larger",
            grid.size[0], grid.size[1], grid.size[2],
            bytesText(4 * static_cast<double>(grid.voxels()))));
    }
    return map;
}

template <class Work>
void forEachSlab(const ImageGrid& grid, const Work& work) {
    const std::size_t slabs = (grid.size[2] + kSlab - 1) / kSlab;
    parallelFor(std::size_t{0}, slabs, [&](std::size_t s) {
        work(s, SliceRange{s * kSlab, std::min((s + 1) * kSlab, grid.size[2])});
    });
}

/// Voxels along an axis of that length. @throws ParameterError
std::size_t voxelsAlong(double length, double spacing) {
    const double count = std::ceil(length / spacing - 1e-6);
    if (!(count < 1e6))
        throw ParameterError(fmt::format(
            "`voxelSpacing`: voxels of {:g} mm are too small for {:.4g} mm", spacing, length));
    return static_cast<std::size_t>(std::max(1.0, count));
}

}  // namespace

ImageGrid withSpacing(const ImageGrid& grid, const Vec<3>& spacing) {
    ImageGrid other = grid;
    Vec<3> shift{{-0.5, -0.5, -0.5}};
    other.origin = grid.at(shift);  // the corner
    for (std::size_t d = 0; d < 3; ++d) {
        const double old = length(grid.step[d]);
        other.size[d] = voxelsAlong(old * static_cast<double>(grid.size[d]), spacing.c[d]);
        other.step[d] = grid.step[d] * (spacing.c[d] / old);
        other.origin += 0.5 * other.step[d];
    }
    return other;
}

ImageGrid gridAround(const Box<3>& box, const Vec<3>& spacing) {
    ImageGrid grid;
    for (std::size_t d = 0; d < 3; ++d) {
        const double s = spacing.c[d];
        grid.size[d] = voxelsAlong(box.size().c[d], s) + 2;
        grid.step[d] = {};
        grid.step[d].c[d] = s;
        grid.origin.c[d] = box.lo.c[d] - s / 2;
    }
    return grid;
}

LabelMap labelMapOf(const std::vector<Sphere<3>>& spheres, const std::vector<std::int32_t>& labels,
                    const ImageGrid& grid) {
    LabelMap map = emptyMap(grid);
    const Vec<3> reach = grid.reach();
    std::vector<std::vector<std::uint32_t>> members((grid.size[2] + kSlab - 1) / kSlab);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const SliceRange slices = slicesOf(grid, reach, spheres[i]);
        for (std::size_t s = slices.begin / kSlab; s * kSlab < slices.end; ++s)
            members[s].push_back(static_cast<std::uint32_t>(i));
    }
    forEachSlab(grid, [&](std::size_t s, const SliceRange& slab) {
        for (const std::uint32_t i : members[s]) {
            const SliceRange own = slicesOf(grid, reach, spheres[i]);
            forEachVoxelIn(grid, reach, spheres[i],
                           {std::max(own.begin, slab.begin), std::min(own.end, slab.end)},
                           [&](std::size_t voxel) { map.labels[voxel] = labels[i]; });
        }
    });
    return map;
}

LabelMap labelMapOf(const std::function<std::function<std::int32_t(const Vec<3>&)>()>& sampler,
                    const ImageGrid& grid) {
    LabelMap map = emptyMap(grid);
    forEachSlab(grid, [&](std::size_t, const SliceRange& slab) {
        const auto labelAt = sampler();
        std::size_t voxel = slab.begin * grid.size[1] * grid.size[0];
        for (std::size_t z = slab.begin; z < slab.end; ++z)
            for (std::size_t y = 0; y < grid.size[1]; ++y)
                for (std::size_t x = 0; x < grid.size[0]; ++x)
                    map.labels[voxel++] =
                        labelAt(grid.at({{static_cast<double>(x), static_cast<double>(y),
                                          static_cast<double>(z)}}));
    });
    return map;
}

}  // namespace vdbpack
