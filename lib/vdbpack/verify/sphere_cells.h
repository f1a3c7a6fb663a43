// Private to verify: spheres in cells, one grid for each class of sizes, and their overlaps.
//
// Independent of core/cell_levels.h, which the packer uses: an error there must not hide itself.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace vdbpack {

/// A cell by its number along each axis (2D: the last is 0).
using CellNumbers = std::array<std::int64_t, 3>;

/// Spheres of about one size, sorted into cells as wide as the largest.
///
/// Cells are numbered from the origin without end, and share a limited number of slots: the cells
/// of a row along x have slots in a row. Where all cells between the first and the last sphere fit
/// in, each has a slot of its own; else rows begin at slots picked by a hash, and one slot may
/// hold spheres of several cells. Memory is proportional to the number of spheres in either case.
template <int Dim>
class SphereCells {
public:
    SphereCells(const std::vector<Sphere<Dim>>& spheres, const std::vector<std::uint32_t>& members);

    /// The number of the cell at `x` along any axis. It never falls where `x` rises, so that a
    /// range of positions is a range of cells whatever the rounding. Whole cells up to 2^52 of
    /// them; farther out, where doubles are sparser than cells, each double is a cell.
    std::int64_t cellAt(double x) const {
        const double v = x * perCell_;
        if (std::abs(v) < 0x1p52) return static_cast<std::int64_t>(std::floor(v));
        const double size = std::abs(v), first = 0x1p52;
        std::int64_t bits, firstBits;  // of positive doubles: rise with them
        std::memcpy(&bits, &size, sizeof bits);
        std::memcpy(&firstBits, &first, sizeof firstBits);
        const std::int64_t cell = (std::int64_t{1} << 52) + (bits - firstBits);
        return v < 0 ? -cell : cell;
    }
    CellNumbers cellsOf(const Vec<Dim>& x) const {
        CellNumbers cell{};
        for (int i = 0; i < Dim; ++i) cell[static_cast<std::size_t>(i)] = cellAt(x[i]);
        return cell;
    }

    /// Calls `visit(sphere, j)`, j being its position, for (at least) the spheres in the cells from
    /// `first` to `last` of one row: the first numbers of the two differ at most. A sphere of
    /// another cell may come with them.
    /// @param from  position in `first` before which no sphere of that cell has to be visited.
    template <typename Visit>
    void forEachInRow(const CellNumbers& first, std::int64_t last, const Visit& visit,
                      std::size_t from = 0) const {
        const auto cells = static_cast<std::uint64_t>(last - first[0]);
        if (cells >= mask_) return visitSlots(0, mask_, visit);
        const std::uint64_t a = slotOf(first), b = (a + cells) & mask_;
        if (a <= b) return visitSlots(a, b, visit, from);
        visitSlots(0, b, visit);
        visitSlots(a, mask_, visit, from);
    }

    std::size_t size() const { return spheres_.size(); }
    const Sphere<Dim>& sphere(std::size_t j) const { return spheres_[j]; }
    std::uint32_t index(std::size_t j) const { return index_[j]; }  ///< in caller's array
    double largestRadius() const { return largestRadius_; }
    double perCell() const { return perCell_; }  ///< cells a mm

private:
    std::uint64_t slotOf(const CellNumbers& cell) const {
        std::uint64_t row = static_cast<std::uint64_t>(cell[1]) * strideY_ +
                            static_cast<std::uint64_t>(cell[2]) * strideZ_;
        if (hashed_) row = (row ^ row >> 32) * 0xbf58476d1ce4e5b9ull >> 20;
        return (row + static_cast<std::uint64_t>(cell[0])) & mask_;
    }
    template <typename Visit>
    void visitSlots(std::uint64_t first, std::uint64_t last, const Visit& visit,
                    std::size_t from = 0) const {
        const std::uint32_t end = start_[last + 1];
        const Sphere<Dim>* const spheres = spheres_.data();
        for (auto j = std::max(start_[first], static_cast<std::uint32_t>(from)); j < end; ++j)
            visit(spheres[j], j);
    }
    void chooseSlots(const std::vector<Sphere<Dim>>& spheres,
                     const std::vector<std::uint32_t>& members);

    double largestRadius_ = 0;
    double perCell_ = 0;
    bool hashed_ = false;
    std::uint64_t strideY_ = 0, strideZ_ = 0;
    std::uint64_t mask_ = 0;            ///< slots, a power of two, less one
    std::vector<std::uint32_t> start_;  ///< first sphere of each slot, and the end
    std::vector<Sphere<Dim>> spheres_;  ///< in order of slots
    std::vector<std::uint32_t> index_;  ///< of each in the caller's array
};

/// Spheres of any mix of sizes: cells for each class of radii, within a factor of three.
template <int Dim>
class SphereClasses {
public:
    /// @param spheres  usable (`requireVerifiable`).
    explicit SphereClasses(const std::vector<Sphere<Dim>>& spheres);

    /// Calls `visit(i, a, j, b, squaredDistance)` once for each pair of overlapping spheres `a` and
    /// `b` at indices i and j, from many threads at once. `stopped()` is asked once a sphere and
    /// ends the search when true.
    template <typename Visit, typename Stopped>
    void forEachOverlap(const Visit& visit, const Stopped& stopped) const {
        for (std::size_t coarse = 0; coarse < classes_.size(); ++coarse) {
            overlapsWithin(classes_[coarse], visit, stopped);
            for (std::size_t fine = coarse + 1; fine < classes_.size(); ++fine)
                overlapsAcross(classes_[coarse], classes_[fine], visit, stopped);
        }
    }

private:
    template <typename Visit, typename Stopped>
    void overlapsWithin(const SphereCells<Dim>& cells, const Visit& visit,
                        const Stopped& stopped) const;
    template <typename Visit, typename Stopped>
    void overlapsAcross(const SphereCells<Dim>& coarse, const SphereCells<Dim>& fine,
                        const Visit& visit, const Stopped& stopped) const;

    std::vector<SphereCells<Dim>> classes_;  ///< by falling radius
};

/// The cells that a sphere's partners may lie in.
template <int Dim>
struct CellRange {
    CellNumbers first{}, last{};

    CellRange(const SphereCells<Dim>& cells, const Sphere<Dim>& s) {
        // A little more than the two radii, so that rounding of their sum loses nothing.
        const double reach = (s.radius + cells.largestRadius()) * (1 + 1e-9);
        for (int i = 0; i < Dim; ++i) {
            first[static_cast<std::size_t>(i)] = cells.cellAt(s.center[i] - reach);
            last[static_cast<std::size_t>(i)] = cells.cellAt(s.center[i] + reach);
        }
    }
};

/// Visits the overlaps of one sphere with those in a row of cells of another (or its own) class.
template <int Dim, typename Visit>
struct RowSearch {
    const SphereCells<Dim>& from;
    std::size_t i;
    const SphereCells<Dim>& through;
    const Visit& visit;
    const CellNumbers* own = nullptr;  ///< cell of sphere i, if the two classes are the same

    /// Cells `first` to `last` of a row; in slots shared with other cells a sphere counts only for
    /// its own. Of two spheres in one cell, the later one is visited from the earlier one.
    void operator()(const CellNumbers& first, std::int64_t last) const {
        const Sphere<Dim> a = from.sphere(i);
        through.forEachInRow(
            first, last,
            [&](const Sphere<Dim>& b, std::uint32_t j) {
                const double square = squaredLength(a.center - b.center);
                const double sum = a.radius + b.radius;
                if (!(square < sum * sum)) return;
                const CellNumbers cell = through.cellsOf(b.center);
                if (cell[1] != first[1] || cell[2] != first[2]) return;
                if (cell[0] < first[0] || cell[0] > last) return;
                if (own && cell == *own && j <= i) return;
                visit(from.index(i), a, through.index(j), b, square);
            },
            own && first == *own ? i + 1 : 0);
    }
};

template <int Dim>
template <typename Visit, typename Stopped>
void SphereClasses<Dim>::overlapsWithin(const SphereCells<Dim>& cells, const Visit& visit,
                                        const Stopped& stopped) const {
    const auto work = [&](const IndexRange& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            if (stopped()) return;
            // Of two cells the later one, by z, y, x, is searched from the earlier one.
            const CellNumbers own = cells.cellsOf(cells.sphere(i).center);
            const RowSearch<Dim, Visit> search{cells, i, cells, visit, &own};
            const CellRange<Dim> range(cells, cells.sphere(i));
            search(own, range.last[0]);
            for (std::int64_t y = own[1] + 1; y <= range.last[1]; ++y)
                search({range.first[0], y, own[2]}, range.last[0]);
            for (std::int64_t z = own[2] + 1; z <= range.last[2]; ++z)
                for (std::int64_t y = range.first[1]; y <= range.last[1]; ++y)
                    search({range.first[0], y, z}, range.last[0]);
        }
    };
    parallelFor(IndexRange(0, cells.size(), 64), work);
}

template <int Dim>
template <typename Visit, typename Stopped>
void SphereClasses<Dim>::overlapsAcross(const SphereCells<Dim>& coarse,
                                        const SphereCells<Dim>& fine, const Visit& visit,
                                        const Stopped& stopped) const {
    // From the coarse spheres where they are few, but not where each meets too many fine rows.
    const double across = (coarse.largestRadius() + fine.largestRadius()) * fine.perCell() + 1;
    const bool fromCoarse = std::pow(across, Dim - 1) * static_cast<double>(coarse.size()) <
                            5 * static_cast<double>(fine.size());
    const SphereCells<Dim>& from = fromCoarse ? coarse : fine;
    const SphereCells<Dim>& through = fromCoarse ? fine : coarse;
    const auto work = [&](const IndexRange& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            if (stopped()) return;
            const RowSearch<Dim, Visit> search{from, i, through, visit};
            const CellRange<Dim> range(through, from.sphere(i));
            for (std::int64_t z = range.first[2]; z <= range.last[2]; ++z)
                for (std::int64_t y = range.first[1]; y <= range.last[1]; ++y)
                    search({range.first[0], y, z}, range.last[0]);
        }
    };
    parallelFor(IndexRange(0, from.size(), 16), work);
}

}  // namespace vdbpack
