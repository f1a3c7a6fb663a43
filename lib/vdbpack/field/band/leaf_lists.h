// Private: which triangles, edges and vertices each leaf of a narrow band has to look at.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/field/band/band_features.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

/// Voxels along a side of a leaf, leaves along a side of a node.
inline constexpr int kLeafSide = 8, kNodeSide = 16;

/// A leaf of 8^3 voxels and its candidates.
struct BandLeaf {
    std::array<std::int32_t, 3> origin;  ///< its first voxel
    std::array<std::uint64_t, 4> start;  ///< triangles, edges, vertices in `LeafLists::items`; end
    std::array<std::uint64_t, 2> point;  ///< in `LeafLists::points`, and their end
};

/// A voxel over a triangle so small that its voxels are listed, not the triangle.
struct BandPoint {
    std::uint32_t voxel;  ///< number in the leaf, as `voxelInLeaf` has it
    float square;         ///< of the distance, voxels
};

/// Number of a voxel in its leaf: by blocks of 4^3, of 2^3 within these, by x, y, z within these.
constexpr std::uint32_t voxelInLeaf(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    std::uint32_t number = 0;
    for (int bit = 2; bit >= 0; --bit)
        number = number << 3 | (x >> bit & 1) << 2 | (y >> bit & 1) << 1 | (z >> bit & 1);
    return number;
}

/// The leaves that parts of the band may reach, node by node (128^3 voxels).
///
/// Memory: 128 KiB for each node that is met, 4 bytes for each candidate (8 for a point), and 8
/// (12) more while they are made.
class LeafLists {
public:
    LeafLists(const BandMesh& mesh, const BandFeatures& features, const Callbacks& callbacks);

    /// Node `n` holds the leaves [nodeStart[n], nodeStart[n + 1]); nodes by z, y, x.
    std::vector<std::uint32_t> nodeStart;
    std::vector<BandLeaf> leaves;
    std::vector<std::uint32_t> items;
    std::vector<BandPoint> points;

    std::array<std::int32_t, 3> firstNode{}, nodeCount{};
    std::array<std::int32_t, 3> nodeOrigin(std::size_t n) const;  ///< its first voxel
};

}  // namespace vdbpack
