// Private to measure: voxels painted with the diameter of the largest ball that covers them.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/ridge.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A voxel that no ball covers.
struct Leftover {
    std::int64_t x, y, z;
    std::size_t voxel;
};

/// All balls of one phase by falling radius, with a list of those that reach into each tile of the
/// image.
class BallPainting {
public:
    BallPainting(const VoxelImage& image, std::vector<RidgeBall> balls);

    std::size_t tiles() const {
        return static_cast<std::size_t>(tiles_[0] * tiles_[1] * tiles_[2]);
    }
    /// Paints the voxels of one tile in the phase `solid` and in the total volume.
    /// @return those that no ball covers.
    std::vector<Leftover> paint(std::size_t tile, const VoxelImage& image, const Ridge& ridge,
                                bool solid, std::vector<float>& thickness) const;

private:
    template <class Visit>
    void forEachTile(const RidgeBall& ball, const Visit& visit) const;

    std::array<std::int64_t, 3> size_, tiles_{};
    std::vector<RidgeBall> balls_;
    std::vector<std::size_t> start_;     ///< first member of each tile, and the end
    std::vector<std::uint32_t> member_;  ///< balls of the tiles
};

}  // namespace vdbpack
