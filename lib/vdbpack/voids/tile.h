// Private: the voxels of one tile, and how voids are stamped into them eight at a time.
#pragma once

#include "vdbpack/core/ellipsoid.h"

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

/// What is known of a void before a tile is stamped with it.
template <int Dim>
struct VoidAtTile {
    double lower = 0;  ///< no point of the tile is deeper inside or nearer to the void, mm
    double upper = 0;  ///< no point of the tile is farther away from it, mm
};

/// A void to be stamped, and `lower` of `VoidAtTile`.
template <int Dim>
struct NearVoid {
    const Ellipsoid<Dim>* ellipsoid;
    double lower;
};

/// Distances at the centers of a tile's voxels, mm, in an order of its own (`inLeaf`).
template <int Dim>
class Tile {
public:
    /// @param inside, outside  widths of the band, mm: values are clamped to them.
    Tile(const Vec<Dim>& firstCenter, double voxelSize, double inside, double outside);

    /// Takes the least of the present value and the distances to voids at every voxel.
    /// @param voids  by rising lower bound: those no nearer than all that is there change nothing.
    void stamp(const std::vector<NearVoid<Dim>>& voids);
    /// All voxels lie inside, deeper than the band.
    void fillInside();
    bool isInside() const;   ///< all values are those of the band's inner end
    bool isOutside() const;  ///< all values are those of its outer end

    float outside() const { return outside_; }
    Vec<Dim> centerOf(std::size_t voxel) const;
    std::size_t countInside() const;  ///< voxels with negative values
    /// Copies the values to where the last coordinate counts fastest, `stride` apart.
    /// @param active  set to those within the band.
    void copyTo(float* values, std::size_t stride, std::bitset<kTileVoxels<Dim>>& active) const;
    std::array<float, kTileVoxels<Dim>>& values() { return values_; }
    const std::array<float, kTileVoxels<Dim>>& values() const { return values_; }

private:
    struct Stamp;
    struct Batch;
    /// A block of eight voxels, and a void of a batch.
    struct Pair {
        std::uint16_t block, ellipsoid;
    };
    static constexpr std::size_t kMostPairs = 512;

    void stamp(const Batch& batch);
    void stamp(const Batch& batch, std::array<Pair, kMostPairs>& pairs, std::size_t count);

    Vec<Dim> first_;
    double voxelSize_;
    float inside_, outside_;
    alignas(32) std::array<float, kTileVoxels<Dim> / kTileSide> blockMax_;  ///< of eight voxels
    alignas(32) std::array<float, kTileVoxels<Dim>> values_;
};

/// Bounds on the distances of a tile's voxels to a void, from that of its middle.
template <int Dim>
VoidAtTile<Dim> boundsAt(const Ellipsoid<Dim>& ellipsoid, const Vec<Dim>& middle, double radius);

extern template class Tile<2>;
extern template class Tile<3>;
extern template VoidAtTile<2> boundsAt(const Ellipsoid<2>&, const Vec<2>&, double);
extern template VoidAtTile<3> boundsAt(const Ellipsoid<3>&, const Vec<3>&, double);

}  // namespace vdbpack
