#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/field/voxel_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

/// The voxels whose value is negative, in the grid's indices.
CoordBBox insideBounds(const FloatGrid& grid) {
    CoordBBox box;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto value = leaf->cbeginValueAll(); value; ++value)
            if (*value < 0) box.expand(value.getCoord());
    auto tile = grid.tree().cbeginValueAll();
    tile.setMaxDepth(FloatGrid::TreeType::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        if (!(*tile < 0)) continue;
        CoordBBox part;
        tile.getBoundingBox(part);
        box.expand(part);
    }
    return box;
}

/// Reads the values of one image row by row.
void fill(const FloatGrid& grid, bool ownVoxels, VoxelImage& image) {
    const auto& transform = grid.transform();
    const openvdb::Vec3d origin(image.origin[0], image.origin[1], image.origin[2]);
    const openvdb::Vec3d start = transform.worldToIndex(origin);
    openvdb::Vec3d axis[3];  // index steps for a voxel along x, y, z
    for (int i = 0; i < 3; ++i) {
        openvdb::Vec3d next = origin;
        next[i] += image.voxelSize;
        axis[i] = transform.worldToIndex(next) - start;
    }
    const auto nx = static_cast<std::size_t>(image.size[0]);
    parallelFor(std::int64_t{0}, image.size[2], [&](std::int64_t z) {
        auto accessor = grid.getConstAccessor();
        for (std::int64_t y = 0; y < image.size[1]; ++y) {
            const openvdb::Vec3d row =
                start + axis[1] * static_cast<double>(y) + axis[2] * static_cast<double>(z);
            float* out = &image.distance[static_cast<std::size_t>(z * image.size[1] + y) * nx];
            for (std::size_t x = 0; x < nx; ++x) {
                const openvdb::Vec3d at = row + axis[0] * static_cast<double>(x);
                if (ownVoxels) {
                    out[x] = accessor.getValue(Coord::round(at));
                    continue;
                }
                const Coord low = Coord::floor(at);
                const openvdb::Vec3d t = at - low.asVec3d();
                const auto between = [](double a, double b, double s) { return a + s * (b - a); };
                const auto line = [&](int j, int k) {
                    return between(double{accessor.getValue(low.offsetBy(0, j, k))},
                                   double{accessor.getValue(low.offsetBy(1, j, k))}, t[0]);
                };
                out[x] = static_cast<float>(between(between(line(0, 0), line(1, 0), t[1]),
                                                    between(line(0, 1), line(1, 1), t[1]), t[2]));
            }
        }
    });
}

/// Around the voxels that are inside, mm.
Box<3> boundsInside(const FloatGrid& grid) {
    const CoordBBox inside = insideBounds(grid);
    if (inside.empty())
        throw InputError("level set: nothing is inside, no value is negative; name another grid");
    Box<3> box;
    for (int corner = 0; corner < 8; ++corner) {
        openvdb::Vec3d at;
        for (int j = 0; j < 3; ++j)
            at[j] = (corner >> j & 1) != 0 ? inside.max()[j] + 0.5 : inside.min()[j] - 0.5;
        const openvdb::Vec3d world = grid.transform().indexToWorld(at);
        box.add({{world[0], world[1], world[2]}});
    }
    return box;
}

}  // namespace

VoxelImage sampleLevelSet(const VdbGrid& vdbGrid, const std::optional<Box<3>>& bounds,
                          double voxelSize, double margin) {
    const FloatGrid& grid = *vdbGrid.grid;
    const auto& transform = grid.transform();
    if (!(voxelSize >= 0) || !std::isfinite(voxelSize))
        throw ParameterError(fmt::format(
            "image of a level set: voxel size {} mm; give a positive one, or 0 for the grid's own",
            voxelSize));
    if (!(margin >= 0) || !std::isfinite(margin))
        throw ParameterError(
            fmt::format("image of a level set: margin {} mm; give 0 or more", margin));
    if (bounds && (bounds->empty() || !isFinite(bounds->lo) || !isFinite(bounds->hi)))
        throw ParameterError(
            "image of a level set: the bounds hold nothing; give a box with a low and a high end");
    const bool ownVoxels = voxelSize == 0;
    if (ownVoxels && !liesAlongAxes(vdbGrid))
        throw InputError(
            "level set: its voxels do not lie along x, y and z; give a voxel size to resample it");
    const double own = transform.voxelSize()[0];
    const double h = ownVoxels ? own : voxelSize;

    const Box<3> box = bounds ? *bounds : boundsInside(grid);
    const double rim = std::ceil(std::max(margin / h - 1e-9, bounds ? 0.0 : 1.0));
    const openvdb::Vec3d zero = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
    std::array<double, 3> n{};
    Vec<3> first;
    for (int j = 0; j < 3; ++j) {
        const auto axis = static_cast<std::size_t>(j);
        first[j] = box.lo[j] + 0.5 * h;
        n[axis] = std::max(1.0, std::ceil((box.hi[j] - box.lo[j]) / h - 1e-6));
        if (ownVoxels) {
            // Voxels whose centers are in the box, one on its boundary counting at the low end.
            const double low = std::ceil((box.lo[j] - zero[j]) / h - 1e-6);
            n[axis] = std::ceil((box.hi[j] - zero[j]) / h - 1e-6) - low;
            first[j] = zero[j] + low * h;
        }
        if (!(n[axis] >= 1))
            throw ParameterError(fmt::format(
                "image of a level set: no center of its voxels of {:.4g} mm lies between {:.6g} "
                "and {:.6g} along {}; give larger bounds or a voxel size",
                h, box.lo[j], box.hi[j], "xyz"[j]));
    }
    VoxelImage image = emptyImage(first, n, h, rim);
    fill(grid, ownVoxels, image);
    return image;
}

}  // namespace vdbpack
