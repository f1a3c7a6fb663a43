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

/// Squares of the distances from the voxels of a leaf to the nearest triangle, edge or vertex of
/// those with a region so narrow that they are no candidates: its voxels were visited one by one.
/// Infinite where there is none; in voxels, numbered as `voxelInLeaf`.
using LeafSquares = std::array<std::atomic<float>, kLeafSide * kLeafSide * kLeafSide>;

/// A leaf of 8^3 voxels and its candidates.
struct BandLeaf {
    std::array<std::int32_t, 3> origin{};  ///< its first voxel
    std::array<std::uint64_t, 4>
        start{};  ///< triangles, edges, vertices in `LeafLists::items`; end
    std::unique_ptr<LeafSquares> squares;  ///< null: no such regions
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
/// Memory: 128 KiB for each node that is met, 4 bytes for each candidate, and 8 more while they are
/// made, 2 KiB for each leaf with `squares`.
class LeafLists {
public:
    LeafLists(const BandMesh& mesh, const Callbacks& callbacks);

    /// Node `n` holds the leaves [nodeStart[n], nodeStart[n + 1]); nodes by z, y, x.
    std::vector<std::uint32_t> nodeStart;
    std::vector<BandLeaf> leaves;
    BandFeatures features;  ///< the edges and vertices that are candidates
    std::vector<std::uint32_t> items;

    std::array<std::int32_t, 3> firstNode{}, nodeCount{};
    std::array<std::int32_t, 3> nodeOrigin(std::size_t n) const;  ///< its first voxel
};

}  // namespace vdbpack
