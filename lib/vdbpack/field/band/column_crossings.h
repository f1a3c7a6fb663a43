// Private: where the vertical lines of a lattice cross a closed mesh.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/field/band/band_features.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Crossings of the lattice lines along z with closed triangle meshes, for inside tests by parity.
///
/// Corners are rounded to 2^-24 voxel and triangles are rasterized with integers, so that every
/// line crosses a closed surface an even number of times. A line through an edge or a corner is
/// moved by (e, e^2) with an infinitely small e (simulation of simplicity: Edelsbrunner and Muecke
/// 1990, doi:10.1145/77635.77639).
class ColumnCrossings {
public:
    /// @param mesh  each edge has an even number of triangles.
    /// @throws ResourceError for a lattice of more than 2^32 lines; Interrupted.
    ColumnCrossings(const BandMesh& mesh, const Callbacks& callbacks);

    /// Whether lattice point (x, y, z) is inside: an odd number of crossings lies below it.
    bool inside(std::int32_t x, std::int32_t y, std::int32_t z) const;

    /// Bit k is set where (x, y, z + k) is inside, 0 <= k < 8.
    unsigned insideOfEight(std::int32_t x, std::int32_t y, std::int32_t z) const;

private:
    std::size_t columnOf(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y - y0_) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(x - x0_);
    }
    bool covers(std::int32_t x, std::int32_t y) const {
        return x >= x0_ && x - x0_ < columns_ && y >= y0_ && y - y0_ < rows_;
    }

    std::int32_t x0_ = 0, y0_ = 0, columns_ = 0, rows_ = 0;
    std::vector<std::uint32_t> start_;  ///< of each column in `above_`, and the end
    std::vector<std::int32_t> above_;   ///< first lattice point above each crossing, rising
};

}  // namespace vdbpack
