// Private: distances of the voxels of a leaf to its candidates, eight at a time.
#pragma once

#include "vdbpack/core/lanes.h"
#include "vdbpack/field/band/band_features.h"
#include "vdbpack/field/band/leaf_lists.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace vdbpack {

/// Squared distances of the 512 voxels of a leaf, in voxels, to the nearest of some triangles,
/// edges and vertices.
///
/// Voxels are in blocks of 4^3, of 2^3 within these: the lanes of a vector are the eight blocks of
/// a leaf, the eight blocks of a block or eight voxels. A candidate is compared with the larger
/// blocks first. Constants are computed in double relative to the center of the leaf, so that
/// distances are exact to some 1e-6 voxel wherever the leaf is.
class LeafDistances {
public:
    explicit LeafDistances(const BandMesh& mesh) : mesh_(mesh) {}

    /// Starts a leaf, with the squares it has so far.
    void start(const BandLeaf& leaf);

    void addTriangle(std::uint32_t triangle);
    void addEdge(const BandEdge& edge);
    void addVertex(const BandVertex& vertex);

    /// Distances of the voxels (x, y, 0) to (x, y, 7), voxels.
    Float8 row(unsigned x, unsigned y) const {
        // Voxels z and z + 1 lie side by side for even z.
        const float* const first = squares_.data() + voxelInLeaf(x, y, 0);
        std::array<float, kLanes> squares;
        for (std::size_t z = 0; z < kLanes; z += 2)
            std::memcpy(&squares[z], first + 64 * (z >> 2) + 8 * (z >> 1 & 1u), 2 * sizeof(float));
        return squareRoot(load(squares.data()));
    }

private:
    const BandMesh& mesh_;
    Vec<3> center_;
    alignas(32) std::array<float, 512> squares_;  ///< as `voxelInLeaf` numbers them
};

}  // namespace vdbpack
