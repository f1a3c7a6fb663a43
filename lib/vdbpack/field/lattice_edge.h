// Points and edges of a cubic lattice.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace vdbpack {

/// Indices of a point of a lattice, of a voxel of a grid.
using VoxelIndex = std::array<int, 3>;

inline VoxelIndex offsetBy(const VoxelIndex& v, int i, int j, int k) {
    return {v[0] + i, v[1] + j, v[2] + k};
}

inline VoxelIndex offsetAlong(VoxelIndex v, int axis, int steps) {
    v[static_cast<std::size_t>(axis)] += steps;
    return v;
}

/// The point in voxels about the origin of the lattice.
inline Vec<3> pointOf(const VoxelIndex& v) {
    return {{static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])}};
}

/// An edge from a point to the next one along an axis, in one number that rises with z, then y,
/// then x. Indices are less than `kFarthestIndex` from zero.
using EdgeKey = std::uint64_t;
inline constexpr int kFarthestIndex = 1 << 19;

inline EdgeKey edgeKey(const VoxelIndex& lower, int axis) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + kFarthestIndex); };
    return part(lower[2]) << 42 | part(lower[1]) << 22 | part(lower[0]) << 2 |
           static_cast<std::uint64_t>(axis);
}

/// Lower end and axis of an edge.
inline std::pair<VoxelIndex, int> edgeOf(EdgeKey key) {
    constexpr std::uint64_t kMask = (1u << 20) - 1;
    const auto part = [&](int shift) {
        return static_cast<int>(key >> shift & kMask) - kFarthestIndex;
    };
    return {{part(2), part(22), part(42)}, static_cast<int>(key & 3)};
}

}  // namespace vdbpack
