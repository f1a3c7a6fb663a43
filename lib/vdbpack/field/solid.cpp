#include "vdbpack/field/solid.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/interior_components.h"
#include "vdbpack/field/vdb_grid.h"

#include <openvdb/tools/Merge.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tree/NodeManager.h>

#include <algorithm>
#include <new>
#include <vector>

namespace vdbpack {

namespace {

using openvdb::FloatGrid;
using Tree = FloatGrid::TreeType;

FloatGrid::Ptr difference(const FloatGrid& surface, const FloatGrid& voids) {
    // `csgDifferenceCopy` never returns where memory ends while it joins what its threads made.
    const FloatGrid::Ptr grid = surface.deepCopy();
    openvdb::tools::CsgDifferenceOp<Tree> operation(voids.constTree(), openvdb::DeepCopy());
    openvdb::tree::DynamicNodeManager<Tree>(grid->tree()).foreachTopDown(operation);
    grid->setName("solid");
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
}

/// For each component whether it contains a part of the wall, that is voxels with the distances of
/// `surface`, in the shell.
std::vector<bool> touchingWall(InteriorComponents& components, const FloatGrid& surface,
                               const std::function<bool(const Vec<3>&)>& inShell) {
    std::vector<bool> touches(components.sizes().size());
    const auto wall = surface.getConstAccessor();
    const float background = surface.background();
    components.forEachVoxel(
        [&](InteriorComponents::Leaf& leaf, openvdb::Index v, std::uint32_t component) {
            if (touches[component]) return;
            const openvdb::Coord at = leaf.offsetToGlobalCoord(v);
            const float here = wall.getValue(at);
            if (!(here > -background && here == leaf.getValue(v))) return;
            const openvdb::Vec3d x = surface.indexToWorld(at);
            touches[component] = !inShell || inShell({{x[0], x[1], x[2]}});
        });
    return touches;
}

/// True for the largest component alone.
std::vector<bool> largestOf(const InteriorComponents& components) {
    const auto& sizes = components.sizes();
    std::vector<bool> largest(sizes.size());
    if (!sizes.empty())
        largest[static_cast<std::size_t>(std::max_element(sizes.begin(), sizes.end()) -
                                         sizes.begin())] = true;
    return largest;
}

/// The voxels whose centers lie in a cell.
openvdb::CoordBBox voxelsOf(const PeriodicCell<3>& cell, const FloatGrid& grid) {
    openvdb::CoordBBox voxels;
    if (!cell.any()) return voxels;
    const openvdb::Vec3d lo = grid.worldToIndex({cell.box.lo[0], cell.box.lo[1], cell.box.lo[2]}),
                         hi = grid.worldToIndex({cell.box.hi[0], cell.box.hi[1], cell.box.hi[2]});
    return {openvdb::Coord::ceil(lo), openvdb::Coord::floor(hi)};
}

}  // namespace

Solid cutVoids(const VdbGrid& surface, const VdbGrid& voids, double shell, bool keepConnected,
               const std::function<bool(const Vec<3>&)>& inShell, const PeriodicCell<3>& cell) {
    if (surface.grid->transform() != voids.grid->transform())
        throw ParameterError("surface and voids lie on different lattices; stamp on the surface's");
    try {
        const FloatGrid::Ptr grid = difference(*surface.grid, *voids.grid);
        InteriorComponents components(grid->tree(), voxelsOf(cell, *grid), cell.wraps);
        const auto attached =
            shell > 0 ? touchingWall(components, *surface.grid, inShell) : largestOf(components);
        Solid solid;
        std::uint64_t all = 0, kept = 0;
        for (std::size_t i = 0; i < attached.size(); ++i) {
            const std::uint64_t voxels = components.sizes()[i];
            solid.components += voxels > 0;
            all += voxels;
            if (attached[i]) kept += voxels;
        }
        solid.attached = all > 0 ? static_cast<double>(kept) / static_cast<double>(all) : 0;
        const double h = grid->voxelSize()[0];
        if (keepConnected) solid.dropped = static_cast<double>(all - kept) * h * h * h;
        if (keepConnected && kept < all)
            components.drop(grid->background(), [&](std::uint32_t c) { return attached[c]; });
        openvdb::tools::pruneLevelSet(grid->tree());
        solid.grid = std::make_shared<VdbGrid>(grid);
        return solid;
    } catch (const std::bad_alloc&) {
        throw ResourceError("not enough memory to cut the voids; give a larger `voids.voxelSize`");
    }
}

}  // namespace vdbpack
