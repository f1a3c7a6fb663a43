#include "vdbpack/field/level_set.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/vdb_grid.h"

#include <fmt/format.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <cmath>
#include <vector>

namespace vdbpack {

using openvdb::FloatGrid;

TriangleMesh levelSetMesh(const VdbGrid& given, const std::string& name, double adaptivity) {
    const FloatGrid::Ptr grid = given.grid->copy();
    const openvdb::math::Transform transform = grid->transform();
    // Contoured in voxels and moved in double: a translation far from zero would cost digits.
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0));
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0, adaptivity);

    TriangleMesh mesh;
    mesh.vertices.reserve(points.size());
    for (const openvdb::Vec3s& p : points) {
        const openvdb::Vec3d x = transform.indexToWorld(openvdb::Vec3d(p));
        mesh.vertices.push_back({{x[0], x[1], x[2]}});
        if (!isFinite(mesh.vertices.back()))
            throw InputError(
                fmt::format("{}: the contour of level set '{}' is not finite at voxel ({}, {}, "
                            "{}); write it again",
                            name, grid->getName(), p[0], p[1], p[2]));
    }
    // OpenVDB winds its polygons clockwise seen from outside. A mirroring transform turns that
    // round.
    const bool mirrored = transform.baseMap()->determinant() < 0;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (mirrored)
            mesh.triangles.push_back({a, b, c});
        else
            mesh.triangles.push_back({a, c, b});
    };
    mesh.triangles.reserve(triangles.size() + 2 * quads.size());
    for (const openvdb::Vec3I& t : triangles) add(t[0], t[1], t[2]);
    for (const openvdb::Vec4I& q : quads) {
        add(q[0], q[1], q[2]);
        add(q[0], q[2], q[3]);
    }
    if (mesh.triangles.empty())
        throw InputError(
            fmt::format("{}: level set '{}' has no zero contour; name another grid with `gridName`",
                        name, grid->getName()));
    return mesh;
}

Box<3> bandBounds(const VdbGrid& grid) {
    const auto voxels = grid.grid->evalActiveVoxelBoundingBox();
    const auto world = grid.grid->transform().indexToWorld(
        openvdb::BBoxd(voxels.min().asVec3d(), voxels.max().asVec3d()));
    Box<3> box;
    for (int d = 0; d < 3; ++d) {
        box.lo[d] = world.min()[d];
        box.hi[d] = world.max()[d];
    }
    return box;
}

std::string levelSetName(const VdbGrid& grid) {
    return grid.grid->getName();
}

std::shared_ptr<const VdbGrid> renamed(const VdbGrid& grid, const std::string& name) {
    auto copy = std::make_shared<VdbGrid>(grid);
    copy->grid = grid.grid->copy();
    copy->grid->setName(name);
    return copy;
}

double voxelSizeOf(const VdbGrid& grid) {
    return grid.grid->voxelSize()[0];
}

Vec<3> originOf(const VdbGrid& grid) {
    const openvdb::Vec3d origin = grid.grid->indexToWorld(openvdb::Vec3d(0));
    return {{origin[0], origin[1], origin[2]}};
}

std::uint64_t activeVoxels(const VdbGrid& grid) {
    return grid.grid->activeVoxelCount();
}

bool liesAlongAxes(const VdbGrid& grid) {
    const openvdb::Mat4d m = grid.grid->transform().baseMap()->getAffineMap()->getMat4();
    const double h = grid.grid->voxelSize()[0];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(m[i][j] - (i == j ? h : 0)) > 1e-9 * h) return false;
    return true;
}

}  // namespace vdbpack
