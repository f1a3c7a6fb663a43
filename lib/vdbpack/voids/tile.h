// Private: the voxels of one tile, and how voids are stamped into them eight at a time.
#pragma once

#include "vdbpack/core/ellipsoid.h"

#include <array>
#include <cstddef>
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

/// Distances at the centers of a tile's voxels, mm, in an order of its own (`inLeaf`).
template <int Dim>
class Tile {
public:
    /// @param inside, outside  widths of the band, mm: values are clamped to them.
    Tile(const Vec<Dim>& firstCenter, double voxelSize, double inside, double outside);

    /// Takes the smaller of the present value and the distance to a void at every voxel.
    /// @param lower  as of `boundsAt`: a void no nearer than all that is there changes nothing.
    void stamp(const Ellipsoid<Dim>& ellipsoid, double lower);
    /// All voxels lie inside, deeper than the band.
    void fillInside();
    bool isInside() const;   ///< all values are those of the band's inner end
    bool isOutside() const;  ///< all values are those of its outer end

    Vec<Dim> centerOf(std::size_t voxel) const;
    /// Place of a voxel where the last coordinate counts fastest.
    static std::size_t inLeaf(std::size_t voxel);
    std::array<float, kTileVoxels<Dim>>& values() { return values_; }
    const std::array<float, kTileVoxels<Dim>>& values() const { return values_; }

private:
    struct Stamp;

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
