#include "vdbpack/field/either_grid.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <cmath>

namespace vdbpack {

namespace {

constexpr double kFarthest = 1e9;  ///< from the origin, mm

}  // namespace

void requireNear(const std::string& file, const openvdb::Coord& voxel, const Vec<3>& x) {
    if (std::fabs(x[0]) <= kFarthest && std::fabs(x[1]) <= kFarthest &&
        std::fabs(x[2]) <= kFarthest)
        return;
    throw InputError(fmt::format(
        "{}: voxel ({}, {}, {}) lies more than 1e9 mm from the origin; correct the transform", file,
        voxel.x(), voxel.y(), voxel.z()));
}

Box<3> boxAround(const openvdb::CoordBBox& voxels, const openvdb::math::Transform& transform,
                 double scale) {
    openvdb::BBoxd box(voxels.min().asVec3d(), voxels.max().asVec3d());
    box.expand(1.0);
    const auto world = transform.indexToWorld(box);
    return {toVec(world.min()) * scale, toVec(world.max()) * scale};
}

}  // namespace vdbpack
