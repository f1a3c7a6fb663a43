// Level sets read from .vdb files.
#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/read_vdb.h"
#include "vdbpack/field/smallest_voxel.h"
#include "vdbpack/field/vdb_archive.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/io/stated_unit.h"

#include <fmt/format.h>
#include <openvdb/tools/ChangeBackground.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

using openvdb::FloatGrid;

/// The grid named, or the first level set; only its header is read to choose.
FloatGrid::Ptr readLevelSet(const std::string& path, const std::string& gridName) {
    VdbArchive file(path);
    const auto grid = file.find([&](const openvdb::GridBase& head) {
        if (!gridName.empty() && !file.isNamed(head, gridName)) return false;
        const bool isLevelSet =
            head.isType<FloatGrid>() && head.getGridClass() == openvdb::GRID_LEVEL_SET;
        if (!isLevelSet && !gridName.empty())
            throw InputError(fmt::format(
                "{}: grid '{}' is not a level set of floats (type {}, class {}); name one "
                "with `gridName`",
                path, gridName, head.type(),
                openvdb::GridBase::gridClassToString(head.getGridClass())));
        return isLevelSet;
    });
    if (grid) return openvdb::gridPtrCast<FloatGrid>(grid);
    const std::string names = file.list();
    throw InputError(fmt::format(
        "{}: no level set {}; the grids in it are: {}; name one "
        "with `gridName`",
        path, gridName.empty() ? std::string("of floats") : fmt::format("named '{}'", gridName),
        names.empty() ? "none" : names));
}

/// Whether contouring takes no more than a level set of its size is worth. A side of an active tile
/// that is no wall costs nothing; one whose neighbor has the other sign, or is finer, becomes a
/// leaf for each 8 x 8 voxels, and a tile may have 4096 a side.
bool isCheapToContour(const FloatGrid& grid) {
    const double most = 4096 + 16.0 * static_cast<double>(grid.tree().leafCount());
    const auto values = grid.getConstAccessor();
    double leaves = 0;
    auto tile = grid.cbeginValueOn();
    tile.setMaxDepth(FloatGrid::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        const openvdb::CoordBBox box = tile.getBoundingBox();
        const int depth = values.getValueDepth(box.min());
        const double side = box.dim().x() / 8.0;
        for (int axis = 0; axis < 3; ++axis) {
            for (const int step : {-1, 1}) {
                openvdb::Coord beside = step < 0 ? box.min() : box.max();
                beside[axis] += step;
                const bool isWorked = values.getValueDepth(beside) > depth ||
                                      (values.getValue(beside) < 0) != (*tile < 0);
                if (isWorked) leaves += side * side;
            }
        }
        if (leaves > most) return false;
    }
    return true;
}

/// @throws InputError unless all values are finite: contouring looks at inactive neighbors too.
void checkValues(const std::string& path, const FloatGrid& grid) {
    for (auto value = grid.cbeginValueAll(); value; ++value)
        if (!std::isfinite(*value))
            throw InputError(fmt::format(
                "{}: the value of grid '{}' at voxel ({}, {}, {}) is not finite; write it again",
                path, grid.getName(), value.getCoord().x(), value.getCoord().y(),
                value.getCoord().z()));
}

/// @throws InputError unless the level set can be contoured and sampled.
void checkLevelSet(const std::string& path, const FloatGrid& grid) {
    const openvdb::math::Transform& transform = grid.transform();
    if (!transform.isLinear() || !transform.hasUniformScale())
        throw InputError(fmt::format(
            "{}: the voxels of '{}' are not cubes; resample it to a uniform linear transform", path,
            grid.getName()));
    if (grid.activeVoxelCount() == 0)
        throw InputError(fmt::format("{}: level set '{}' is empty; name another with `gridName`",
                                     path, grid.getName()));
    if (!(grid.background() > 0))
        throw InputError(
            fmt::format("{}: level set '{}' has a background of {}, where it is the half-width of "
                        "the band and so positive; write it again",
                        path, grid.getName(), grid.background()));
    if (!isCheapToContour(grid))
        throw InputError(fmt::format(
            "{}: the surface of level set '{}' runs between large active tiles, where it lies in "
            "a narrow band of voxels; rebuild it as a level set",
            path, grid.getName()));
    checkValues(path, grid);
}

/// Millimeters in one unit of the grid's lengths. @param unit  where it states none
double millimetersIn(const FloatGrid& grid, Unit unit) {
    const auto stated = grid.getMetadata<openvdb::StringMetadata>(kUnitKey);
    return millimetersPer(stated ? statedUnit(kUnitComment + stated->value()).value_or(unit)
                                 : unit);
}

/// The grid of floats of that name that is no level set; see `findFogVolume`.
FloatGrid::Ptr readFogVolume(const std::string& path, const std::string& gridName, bool besides) {
    VdbArchive file(path);
    const auto isLevelSet = [](const openvdb::GridBase& head) {
        return head.getGridClass() == openvdb::GRID_LEVEL_SET;
    };
    const auto heads = file.heads();
    if (gridName.empty() && !besides &&
        std::any_of(heads.begin(), heads.end(),
                    [&](const auto& head) { return isLevelSet(*head); }))
        return nullptr;
    return openvdb::gridPtrCast<FloatGrid>(file.find([&](const openvdb::GridBase& head) {
        return head.isType<FloatGrid>() && !isLevelSet(head) &&
               (gridName.empty() || file.isNamed(head, gridName));
    }));
}

FogVolume describe(const FloatGrid& grid) {
    FogVolume fog{grid.getName(), grid.background(), grid.background()};
    for (auto value = grid.cbeginValueAll(); value; ++value) {
        fog.lowest = std::min(fog.lowest, double{*value});
        fog.highest = std::max(fog.highest, double{*value});
    }
    return fog;
}

}  // namespace

TriangleMesh levelSetMesh(const std::string& path, const std::string& gridName, double scale) {
    return levelSetMesh(*levelSetGrid(path, gridName, scale), path);
}

std::optional<FogVolume> findFogVolume(const std::string& path, const std::string& gridName,
                                       bool besides) {
    std::optional<FogVolume> found;
    readVdb(path, [&] {
        if (const auto grid = readFogVolume(path, gridName, besides)) found = describe(*grid);
    });
    return found;
}

TriangleMesh fogVolumeMesh(const std::string& path, const std::string& gridName, double scale,
                           double threshold, Unit unit) {
    FloatGrid::Ptr grid;
    readVdb(path, [&] {
        grid = readFogVolume(path, gridName, true);
        if (!grid)
            throw InputError(fmt::format(
                "{}: holds no fog volume of floats{}, so that `threshold` has no meaning", path,
                gridName.empty() ? "" : fmt::format(" named '{}'", gridName)));
        if (!grid->transform().isLinear())
            throw InputError(
                fmt::format("{}: the voxels of '{}' are not in straight rows; "
                            "resample it to a linear transform",
                            path, grid->getName()));
        checkValues(path, *grid);
        const FogVolume fog = describe(*grid);
        if (!(threshold > grid->background() && threshold < fog.highest))
            throw InputError(fmt::format(
                "{}: no surface of fog volume '{}' has the value {:g}: it is {:g} outside and {:g} "
                "at most; set `threshold` between the two",
                path, fog.grid, threshold, grid->background(), fog.highest));
        // Negative inside, as a level set; contouring winds by the class.
        grid->setGridClass(openvdb::GRID_LEVEL_SET);
        const auto level = static_cast<float>(threshold);
        for (auto value = grid->beginValueAll(); value; ++value) value.setValue(level - *value);
        grid->tree().root().setBackground(level - grid->background(), false);
        grid->transform().postScale(scale * millimetersIn(*grid, unit));
        if (!isCheapToContour(*grid))
            throw InputError(fmt::format(
                "{}: the surface of fog volume '{}' runs between large active tiles; write it with "
                "a gradient of some voxels",
                path, fog.grid));
    });
    return levelSetMesh(VdbGrid(grid), path);
}

bool holdsLevelSet(const std::string& path) {
    try {
        levelSetGrid(path, "", 1);
        return true;
    } catch (const Error&) {
        return false;
    }
}

std::shared_ptr<const VdbGrid> levelSetGrid(const std::string& path, const std::string& gridName,
                                            double scale, Unit unit) {
    if (!(scale > 0) || !std::isfinite(scale))
        throw ParameterError(fmt::format("{}: scale {} must be positive", path, scale));
    FloatGrid::Ptr grid;
    readVdb(path, [&] {
        grid = readLevelSet(path, gridName);
        checkLevelSet(path, *grid);
        const double factor = scale * millimetersIn(*grid, unit);
        const double voxel = grid->voxelSize()[0] * factor;
        if (!(voxel >= kSmallestVoxel))
            throw InputError(fmt::format(
                "{}: the voxels of '{}' are {:g} mm wide, below {:g} mm; check `unit` and `scale`",
                path, grid->getName(), voxel, kSmallestVoxel));
        grid->transform().postScale(factor);
        if (factor == 1) return;
        // Every value, in the band or not, is a distance.
        const auto mm = static_cast<float>(factor);
        for (auto value = grid->beginValueAll(); value; ++value) value.setValue(*value * mm);
        openvdb::tools::changeBackground(grid->tree(), grid->background() * mm);
    });
    return std::make_shared<VdbGrid>(grid);
}

}  // namespace vdbpack
