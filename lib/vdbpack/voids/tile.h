// Private: the voxels of one tile, and how voids are stamped into them eight at a time.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_join.h"

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Voxels along each side of a tile: those of a leaf of an OpenVDB tree.
inline constexpr int kTileSide = 8;

template <int Dim>
constexpr std::size_t kTileVoxels = Dim == 3 ? 512 : 64;

/// Bounds on the signed distances of a tile's points to a void.
template <int Dim>
struct VoidAtTile {
    double lower = 0;  ///< of the least distance, mm
    double upper = 0;  ///< of the largest distance, mm
};

/// A void to stamp, with `lower` of its `VoidAtTile`.
template <int Dim>
struct NearVoid {
    const Ellipsoid<Dim>* ellipsoid;
    double lower;
};

/// Signed distances at the centers of a tile's voxels, mm, eight neighbors in a row.
template <int Dim>
class Tile {
public:
    /// @param inside, outside  widths of the band, mm: values are clamped to them.
    Tile(const Vec<Dim>& firstCenter, double voxelSize, double inside, double outside);

    /// Takes the minimum of the current value and the distances to the voids at every voxel.
    /// @param voids  sorted by rising lower bound, so that the rest is skipped once no value can
    ///               change.
    void stamp(const std::vector<NearVoid<Dim>>& voids);
    /// After `stamp`: joins voids that come near or overlap.
    /// @param voids  all those whose lower bound is less than `how.reach`.
    void join(const std::vector<NearVoid<Dim>>& voids, const VoidJoin& how);
    /// Sets all voxels to the inside, deeper than the band.
    void fillInside();
    bool isInside() const;   ///< all values are at the inner limit of the band
    bool isOutside() const;  ///< all values are at its outer limit

    float outside() const { return outside_; }
    Vec<Dim> centerOf(std::size_t voxel) const;
    std::size_t countInside() const;  ///< voxels with negative values
    /// Copies the values, last coordinate fastest, to positions `stride` apart.
    /// @param active  is set for the voxels within the band.
    void copyTo(float* values, std::size_t stride, std::bitset<kTileVoxels<Dim>>& active) const;
    std::array<float, kTileVoxels<Dim>>& values() { return values_; }
    const std::array<float, kTileVoxels<Dim>>& values() const { return values_; }

private:
    struct Stamp;
    struct Batch;
    class Neighborhood;
    /// A block of eight voxels, and a void of a batch.
    struct Pair {
        std::uint16_t block, ellipsoid;
    };
    static constexpr std::size_t kMostPairs = 512;

    template <class Nearest>
    Float8 withStruts(Float8 before, const Nearest& found, std::uint32_t below,
                      const VoidJoin& how) const;
    void stamp(const Batch& batch);
    void stamp(const Batch& batch, std::array<Pair, kMostPairs>& pairs, std::size_t count);

    Vec<Dim> first_;
    double voxelSize_;
    float inside_, outside_;
    alignas(32) std::array<float, kTileVoxels<Dim> / kTileSide> blockMax_;  ///< of eight voxels
    alignas(32) std::array<float, kTileVoxels<Dim>> values_;
};

/// Bounds for a tile, computed at its middle. @param radius  from there to its farthest voxel, mm.
template <int Dim>
VoidAtTile<Dim> boundsAt(const Ellipsoid<Dim>& ellipsoid, const Vec<Dim>& middle, double radius);

}  // namespace vdbpack
