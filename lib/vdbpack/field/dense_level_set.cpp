#include "vdbpack/field/dense_level_set.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/field/vdb_init.h"

#include <fmt/format.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>

namespace vdbpack {

namespace {

constexpr double kHalfWidth = 3;  // spacings

void check(const DenseLevelSet& dense) {
    const auto& n = dense.size;
    if (n[0] < 3 || n[1] < 3 || n[2] < 3 || dense.values.size() != n[0] * n[1] * n[2])
        throw ParameterError(fmt::format(
            "a level set of {} x {} x {} points with {} values: at least 3 points along each axis "
            "are needed, with a value each",
            n[0], n[1], n[2], dense.values.size()));
    if (!(dense.spacing > 0) || !std::isfinite(dense.spacing))
        throw ParameterError(
            fmt::format("a spacing of {} mm between points is none", dense.spacing));
    std::size_t at = 0;
    bool inside = false;
    for (std::size_t x = 0; x < n[0]; ++x)
        for (std::size_t y = 0; y < n[1]; ++y)
            for (std::size_t z = 0; z < n[2]; ++z, ++at) {
                const float value = dense.values[at];
                if (!std::isfinite(value))
                    throw InputError(fmt::format(
                        "the value of a level set at ({}, {}, {}) is not finite", x, y, z));
                if (!(value < 0)) continue;
                inside = true;
                if (x == 0 || y == 0 || z == 0 || x + 1 == n[0] || y + 1 == n[1] || z + 1 == n[2])
                    throw InputError(fmt::format(
                        "the solid of a level set reaches the border of its array, at ({}, {}, "
                        "{}); add points around it",
                        x, y, z));
            }
    if (!inside) throw InputError("a level set has no negative value, so that nothing is inside");
}

}  // namespace

std::shared_ptr<const VdbGrid> levelSetOf(const DenseLevelSet& dense, const std::string& name) {
    check(dense);
    initializeOpenVdb();
    const auto background = static_cast<float>(kHalfWidth * dense.spacing);
    const auto grid = openvdb::FloatGrid::create(background);
    auto accessor = grid->getAccessor();
    std::size_t at = 0;
    for (std::size_t x = 0; x < dense.size[0]; ++x)
        for (std::size_t y = 0; y < dense.size[1]; ++y)
            for (std::size_t z = 0; z < dense.size[2]; ++z, ++at) {
                const float value = dense.values[at];
                if (std::fabs(value) < background)
                    accessor.setValue(openvdb::Coord(static_cast<int>(x), static_cast<int>(y),
                                                     static_cast<int>(z)),
                                      value);
            }
    openvdb::tools::signedFloodFill(grid->tree());
    const auto transform = openvdb::math::Transform::createLinearTransform(dense.spacing);
    transform->postTranslate(openvdb::Vec3d(dense.origin[0], dense.origin[1], dense.origin[2]));
    grid->setTransform(transform);
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return std::make_shared<VdbGrid>(grid);
}

DenseLevelSet denseLevelSet(const VdbGrid& source) {
    const openvdb::FloatGrid& grid = *source.grid;
    openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) box = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(2));
    DenseLevelSet dense;
    const openvdb::Coord n = box.dim();
    for (int d = 0; d < 3; ++d)
        dense.size[static_cast<std::size_t>(d)] = static_cast<std::size_t>(n[d]);
    dense.spacing = grid.voxelSize()[0];
    const openvdb::Vec3d origin = grid.indexToWorld(box.min());
    dense.origin = {{origin[0], origin[1], origin[2]}};
    dense.values.resize(dense.size[0] * dense.size[1] * dense.size[2]);
    openvdb::tools::Dense<float, openvdb::tools::LayoutZYX> array(box, dense.values.data());
    openvdb::tools::copyToDense(grid, array);
    return dense;
}

}  // namespace vdbpack
