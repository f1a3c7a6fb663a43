// Private to densify: bodies sorted into cells, so that near ones are near in memory.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/densify/body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A grid of cells for each class of radii, so that few small bodies share a cell and few cells
/// are searched for large ones. The same for any number of threads.
///
/// A grid of its own beside core's CellLevels: positions are 64-bit integers here, all bodies are
/// sorted many times per run (in parallel), and the caller moves its data into that order to
/// read whole rows of cells eight bodies at a time.
class BodyCells {
public:
    /// Bodies of radii alike.
    struct Level {
        float largest = 0;  ///< radius, quanta
        double side = 0;    ///< of a cell, quanta
        std::array<std::int64_t, 3> low{}, count{};
        std::uint64_t firstCell = 0;
    };
    /// Cells are `radii` times the largest radius of their level and `more` quanta wide, wider
    /// where bodies are sparse.
    struct Side {
        double radii = 2, more = 0;
    };

    /// Sorts `homes.size()` bodies by cell, and within a cell by their numbers.
    /// @param bodies          only their radii are read, quanta.
    /// @param least, largest  of the radii.
    /// @return whether bodies of rows may be far apart and yet have near low bits (`isNear`).
    /// @throws ResourceError for more than 2^32 cells.
    bool sort(const std::vector<Home>& homes, const Body* bodies, float least, float largest,
              Side side);

    /// The levels of the bodies of all ranks, of which these are a share, and their cells.
    /// @return as `sort`.
    bool lay(const std::vector<Home>& homes, const Body* bodies, float least, float largest,
             Side side, Ranks* ranks);
    /// After `lay`: takes the bodies of a part of space, sorted by their cells among all. The cells
    /// from then on are those between the first and the last body along `axis`, the last one along
    /// which bodies lie apart.
    void take(const std::vector<Home>& homes, const Body* bodies, std::size_t axis);
    /// The level of a radius, and the layer of cells across an axis that a position is in.
    std::size_t levelOf(float radius) const {
        std::size_t k = 0;
        while (radius > levels_[k].largest) ++k;
        return k;
    }
    std::int64_t layerAt(const Level& level, std::int64_t at, std::size_t axis) const {
        return static_cast<std::int64_t>(std::floor(static_cast<double>(at) / level.side)) -
               level.low[axis];
    }
    /// The cell of a position among all cells of all levels.
    std::uint64_t cellAt(const Level& level, const Home& home) const {
        std::int64_t cell = 0;
        for (std::size_t d = 3; d-- > 0;) cell = cell * level.count[d] + layerAt(level, home[d], d);
        return level.firstCell + static_cast<std::uint64_t>(cell);
    }

    /// Number of the body that comes first, second, ...
    const std::vector<std::uint32_t>& order() const { return order_; }
    const std::vector<Level>& levels() const { return levels_; }
    /// The cell of the body at an index of the order.
    std::uint32_t cellOf(std::size_t index) const { return cells_[order_[index]]; }

    /// Calls `visit(first, last)` for ranges of indices in the order that contain (at least) the
    /// bodies of a level with centers within `reach` quanta of a box.
    template <class Visit>
    void forEachRow(const Level& level, const Home& low, const Home& high, double reach,
                    const Visit& visit) const;

private:
    void requireFewCells(std::uint64_t cells) const;

    std::vector<Level> levels_;
    std::vector<std::uint32_t> starts_;  ///< first index of each cell
    std::vector<std::uint32_t> cells_;   ///< of each body
    std::vector<std::uint32_t> order_;
};

template <class Visit>
void BodyCells::forEachRow(const Level& level, const Home& low, const Home& high, double reach,
                           const Visit& visit) const {
    std::array<std::int64_t, 3> lo{}, hi{};
    for (std::size_t d = 0; d < 3; ++d) {
        const auto cell = [&](double at) {
            return static_cast<std::int64_t>(std::floor(at / level.side)) - level.low[d];
        };
        lo[d] = std::max<std::int64_t>(0, cell(static_cast<double>(low[d]) - reach));
        hi[d] =
            std::min<std::int64_t>(level.count[d] - 1, cell(static_cast<double>(high[d]) + reach));
        if (lo[d] > hi[d]) return;
    }
    for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
        for (std::int64_t y = lo[1]; y <= hi[1]; ++y) {
            const auto row = level.firstCell +
                             static_cast<std::uint64_t>((z * level.count[1] + y) * level.count[0]);
            const std::uint32_t first = starts_[row + static_cast<std::size_t>(lo[0])];
            const std::uint32_t last = starts_[row + static_cast<std::size_t>(hi[0]) + 1];
            if (first < last) visit(first, last);
        }
}

}  // namespace vdbpack
