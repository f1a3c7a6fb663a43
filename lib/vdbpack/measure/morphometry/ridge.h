// Private to measure: the balls of the distance ridge of a voxel image.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/surface_distance.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A ball that the surface stops on all sides, in units of the voxel size.
struct RidgeBall {
    Place center{};
    float radius = 0;
};

/// Finds the balls of one image: voxels on the ridge of the distance, moved to the middle between
/// the walls that stop them.
class Ridge {
public:
    /// @param image, surface  must outlive this.
    Ridge(const VoxelImage& image, const SurfaceDistance& surface)
        : image_(image), surface_(surface), size_{image.size} {}

    bool solid(std::size_t voxel) const { return image_.distance[voxel] < 0; }
    bool inTotal(std::size_t voxel) const { return image_.inTotal(voxel); }
    /// Adds the balls in the solid, or in the space around it, that are centered near the voxels of
    /// slice `z`, in their order.
    void collect(std::int64_t z, bool solidBalls, std::vector<RidgeBall>& balls) const;
    /// Twice the distance of a voxel to the surface, voxels.
    float ownThickness(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t voxel) const;

private:
    using Voxel = std::array<std::int64_t, 3>;
    /// Surface points, each once.
    struct Walls {
        std::array<std::uint32_t, 27> points;
        std::size_t count = 0;
    };

    Clearance at(const Place& x, std::size_t voxel, float side) const;
    Clearance refined(const Place& x, std::uint32_t index, float side) const;
    bool interpolate(const Place& x, float& value) const;
    float wayInside(const Place& x, const Place& direction, float limit) const;
    bool isOnRidge(const Voxel& x, std::size_t voxel, float side, float& way) const;
    Walls wallsAround(const Voxel& x, std::uint32_t first) const;
    void moveToMiddle(std::uint32_t first, const Walls& walls, float way, float side,
                      RidgeBall& ball) const;
    float cappedRadius(const RidgeBall& ball, float side) const;
    bool grow(const Voxel& x, RidgeBall& ball) const;

    std::size_t index(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>((z * size_[1] + y) * size_[0] + x);
    }
    bool inside(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return x >= 0 && y >= 0 && z >= 0 && x < size_[0] && y < size_[1] && z < size_[2];
    }

    const VoxelImage& image_;
    const SurfaceDistance& surface_;
    Voxel size_;
};

}  // namespace vdbpack
