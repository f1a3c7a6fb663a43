// Private to domain: cubic cells over facets, and which of them a facet meets.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/facet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A block of cubic cells that covers a box.
///
/// A grid of its own beside core's CellLevels and densify's BodyCells: those sort points, one cell
/// each, while a facet is listed in every cell that it meets.
template <int Dim>
struct FacetCells {
    using Index = std::array<int, static_cast<std::size_t>(Dim)>;

    Box<Dim> bounds;
    double edge = 1;     ///< of a cell, mm
    double inverse = 1;  ///< 1 / edge
    Index count{};       ///< cells along each axis

    /// Sets the edge to `wanted` (mm), or larger: at most 8 cells per facet (and 32768 more), and
    /// no cells that rounding could confuse.
    void setEdge(double wanted, std::size_t facets);

    std::size_t size() const {
        std::size_t cells = 1;
        for (const int n : count) cells *= static_cast<std::size_t>(n);
        return cells;
    }
    /// The cell of a coordinate along an axis, the outermost where it lies outside.
    int along(double coordinate, int axis) const {
        const double index = std::floor((coordinate - bounds.lo[axis]) * inverse);
        const auto last = count[static_cast<std::size_t>(axis)] - 1;
        return static_cast<int>(std::clamp(index, 0.0, static_cast<double>(last)));
    }
    std::uint32_t flat(const Index& index) const {
        std::uint32_t cell = 0;
        for (std::size_t i = static_cast<std::size_t>(Dim); i-- > 0;)
            cell =
                cell * static_cast<std::uint32_t>(count[i]) + static_cast<std::uint32_t>(index[i]);
        return cell;
    }
};

/// A facet listed in a cell.
struct FacetEntry {
    std::uint32_t cell, facet;
};

/// Appends an entry for every cell that the facet number `id` meets; a few more cells may be
/// listed, never one too few. Stops early once `entries` has more than `most`.
template <int Dim>
void listCells(const FacetCells<Dim>& cells, const Facet<Dim>& facet, std::uint32_t id,
               std::size_t most, std::vector<FacetEntry>& entries);

/// For each cell how many rings of cells around it are known to be empty, `most` at most: a
/// chessboard distance.
/// @param start  first entry of each cell, and one past the last.
template <int Dim>
std::vector<std::uint8_t> emptyRings(const FacetCells<Dim>& cells,
                                     const std::vector<std::uint32_t>& start, std::uint8_t most);

}  // namespace vdbpack
