// Level sets put together from tiles of 8³ voxels that are made in parallel.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/field/lattice_edge.h"

#include <bitset>
#include <cstddef>
#include <memory>
#include <string>

namespace vdbpack {

class VdbGrid;

/// The values of one tile: a leaf of OpenVDB's tree, filled in place.
class LevelSetTile {
public:
    static constexpr int kSide = 8;
    static constexpr std::size_t kVoxels = 512;

    /// No tile.
    LevelSetTile();
    /// @param first  its voxel of the lowest indices, multiples of 8.
    /// @param value  of all voxels, none of them in the band.
    LevelSetTile(const VoxelIndex& first, float value);
    ~LevelSetTile();
    LevelSetTile(LevelSetTile&&) noexcept;
    LevelSetTile& operator=(LevelSetTile&&) noexcept;

    explicit operator bool() const { return leaf_ != nullptr; }
    /// The values, the last index counting fastest.
    float* values();
    /// Which voxels lie in the band, in the same order.
    void setActive(const std::bitset<kVoxels>& active);

private:
    friend class LevelSetBuilder;
    struct Leaf;
    std::unique_ptr<Leaf> leaf_;
};

/// Takes tiles one after another; what is not added lies outside.
class LevelSetBuilder {
public:
    /// Edge of the large cubes that `addInside` takes.
    static constexpr int kLargeSide = 128;

    /// @param inside, outside  widths of the band, mm.
    LevelSetBuilder(float inside, float outside);
    ~LevelSetBuilder();

    void add(LevelSetTile tile);
    /// A cube of `side` voxels (8 or 128) deeper inside than the band.
    void addInside(const VoxelIndex& first, int side);
    /// @param origin  center of the voxel (0, 0, 0), mm.
    std::shared_ptr<const VdbGrid> finish(const std::string& name, const Vec<3>& origin,
                                          double voxelSize);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace vdbpack
