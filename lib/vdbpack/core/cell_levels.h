// Spheres in cells, level by level of size, and all their close pairs.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdbpack {

/// Beyond it products of lengths would overflow; mm.
inline constexpr double kLargestLength = 1e30;

/// Refuses spheres that cannot be measured.
/// @throws InputError naming the first sphere whose position or radius is not a usable number;
/// ResourceError above 4e9 spheres.
template <int Dim>
void requireUsable(const std::vector<Sphere<Dim>>& spheres);

/// Spheres sorted into cells, one grid of cells for each class of radii (a factor of 2 to 4).
///
/// Within a class a cell holds a bounded number of disjoint spheres, whatever the mix of sizes.
/// A grid whose cells would outnumber its spheres by far (spheres far apart) closes up the empty
/// gaps of each axis, and keeps a sorted list of occupied cells if that is not enough: memory is
/// proportional to the number of spheres, and every pair in reach is still found.
///
/// Grids of cells that are not built on this one, and why: CellList (pack/front) grows sphere by
/// sphere and is searched eight floats at a time; BodyCells (densify) sorts integer positions every
/// few steps, in the same order for any number of threads, and hands out the order itself;
/// PlaneBins (preview) holds boxes in a plane, each in all cells that it meets; SphereCells
/// (verify) shares no code with what it checks.
template <int Dim>
class CellLevels {
public:
    /// @param spheres  usable (`requireUsable`).
    /// @param slack    pairs are close up to a gap of `slack` times the smaller radius, >= 0.
    explicit CellLevels(const std::vector<Sphere<Dim>>& spheres, double slack = 0);

    /// Calls `visit(indexA, sphereA, indexB, sphereB, squaredDistance)` once for each pair closer
    /// than radiusA + radiusB + slack * min(radiusA, radiusB); from many threads at once.
    /// @param visitor  called by each thread for each part of the search, returns `visit`.
    /// @param stopped  called about once per sphere; ends the search when true.
    template <typename Visitor, typename Stopped>
    void forEachPair(const Visitor& visitor, const Stopped& stopped) const;

    /// Calls `visit(index, sphere)` for (at least) each sphere whose surface is closer to `x` than
    /// `reach`, until it returns false. @return whether all calls returned true.
    template <typename Visit>
    bool forEachNear(const Vec<Dim>& x, double reach, const Visit& visit) const;

    double largestRadius() const { return levels_.empty() ? 0 : levels_.front().largestRadius; }

private:
    using Range = std::pair<std::uint32_t, std::uint32_t>;

    /// One axis of a grid: position to cell, monotone, so that neighbors stay neighbors.
    struct Axis {
        double lo = 0;
        double perCell = 0;                 ///< 1 / edge of a cell
        std::int64_t count = 1;             ///< cells
        std::vector<double> occupied;       ///< gaps closed up: lattice coordinates in use, sorted,
        std::vector<std::int64_t> compact;  ///< and the cell of each

        double lattice(double x) const { return std::floor((x - lo) * perCell); }
        std::int64_t cell(double x) const;
        /// Cells that meet [a, b]; first > second if there are none.
        std::pair<std::int64_t, std::int64_t> cells(double a, double b) const;
    };

    struct Level {
        double largestRadius = 0;
        std::array<Axis, static_cast<std::size_t>(Dim)> axes;
        std::vector<std::uint32_t> start;  ///< first sphere of each slot, and the end
        std::vector<std::uint64_t> keys;   ///< cell of each slot; empty where slot == cell
        std::vector<Sphere<Dim>> spheres;  ///< in order of cells
        std::vector<std::uint32_t> index;  ///< of each in the caller's array

        const Axis& axis(int i) const { return axes[static_cast<std::size_t>(i)]; }
        std::size_t slots() const { return start.size() - 1; }
        std::uint64_t key(std::size_t slot) const { return keys.empty() ? slot : keys[slot]; }
        /// Spheres of the cells first..last, which lie in one row along x.
        Range row(std::uint64_t first, std::uint64_t last) const {
            if (keys.empty()) return {start[first], start[last + 1]};
            const auto a = std::lower_bound(keys.begin(), keys.end(), first);
            const auto b = std::upper_bound(a, keys.end(), last);
            return {start[static_cast<std::size_t>(a - keys.begin())],
                    start[static_cast<std::size_t>(b - keys.begin())]};
        }
    };

    /// Spheres of a level, by their number in the caller's array.
    class Members {
    public:
        /// @param listed  empty: all. @param all  their number
        Members(std::vector<std::uint32_t> listed, std::size_t all)
            : listed_(std::move(listed)), size_(listed_.empty() ? all : listed_.size()) {}
        std::size_t size() const { return size_; }
        std::uint32_t operator[](std::size_t k) const {
            return listed_.empty() ? static_cast<std::uint32_t>(k) : listed_[k];
        }

    private:
        std::vector<std::uint32_t> listed_;
        std::size_t size_;
    };
    static std::uint64_t cellOf(const Level& level, const Vec<Dim>& center);
    void fillLevel(Level& level, const std::vector<Sphere<Dim>>& spheres, const Members& members);
    double layAxes(Level& level, const std::vector<Sphere<Dim>>& spheres, const Members& members,
                   double most) const;
    static void sortByCell(Level& level, const std::vector<Sphere<Dim>>& spheres,
                           const Members& members, std::size_t cells);
    static void sortByKey(Level& level, const std::vector<Sphere<Dim>>& spheres,
                          const Members& members);
    /// Calls `visit(range)` for the rows of cells that meet `box`, until it returns false.
    template <typename Visit>
    static bool forEachRow(const Level& level, const Box<Dim>& box, const Visit& visit);
    template <typename Visitor, typename Stopped>
    void pairsWithin(const Level& level, const Visitor& visitor, const Stopped& stopped) const;
    template <typename Visitor, typename Stopped>
    void pairsAcross(const Level& coarse, const Level& fine, const Visitor& visitor,
                     const Stopped& stopped) const;

    template <typename Visit>
    void testPair(const Level& la, std::uint32_t i, const Level& lb, std::uint32_t j,
                  const Visit& visit) const {
        const Sphere<Dim>& a = la.spheres[i];
        const Sphere<Dim>& b = lb.spheres[j];
        const double d2 = squaredLength(a.center - b.center);
        const double reach = a.radius + b.radius + slack_ * std::min(a.radius, b.radius);
        if (d2 < reach * reach) visit(la.index[i], a, lb.index[j], b, d2);
    }

    double slack_ = 0;
    std::vector<Level> levels_;  ///< by falling radius
};

template <int Dim>
template <typename Visit>
bool CellLevels<Dim>::forEachRow(const Level& level, const Box<Dim>& box, const Visit& visit) {
    std::array<std::pair<std::int64_t, std::int64_t>, 3> range{};
    double rows = 1;
    for (int i = 0; i < Dim; ++i) {
        range[static_cast<std::size_t>(i)] = level.axis(i).cells(box.lo[i], box.hi[i]);
        const auto [first, last] = range[static_cast<std::size_t>(i)];
        if (first > last) return true;
        if (i > 0) rows *= static_cast<double>(last - first + 1);
    }
    const auto all = static_cast<std::uint32_t>(level.spheres.size());
    if (rows > static_cast<double>(all)) return visit(Range{0, all});
    const auto nx = static_cast<std::uint64_t>(level.axis(0).count);
    const auto ny = static_cast<std::uint64_t>(level.axis(1).count);
    for (auto z = range[2].first; z <= range[2].second; ++z)
        for (auto y = range[1].first; y <= range[1].second; ++y) {
            const auto base =
                (static_cast<std::uint64_t>(z) * ny + static_cast<std::uint64_t>(y)) * nx;
            const Range r = level.row(base + static_cast<std::uint64_t>(range[0].first),
                                      base + static_cast<std::uint64_t>(range[0].second));
            if (r.first < r.second && !visit(r)) return false;
        }
    return true;
}

template <int Dim>
template <typename Visit>
bool CellLevels<Dim>::forEachNear(const Vec<Dim>& x, double reach, const Visit& visit) const {
    for (const Level& level : levels_) {
        const auto box = Box<Dim>{x, x}.grown(reach + level.largestRadius);
        const bool all = forEachRow(level, box, [&](const Range& r) {
            for (std::uint32_t j = r.first; j < r.second; ++j)
                if (!visit(level.index[j], level.spheres[j])) return false;
            return true;
        });
        if (!all) return false;
    }
    return true;
}

template <int Dim>
template <typename Visitor, typename Stopped>
void CellLevels<Dim>::pairsWithin(const Level& level, const Visitor& visitor,
                                  const Stopped& stopped) const {
    const auto nx = static_cast<std::uint64_t>(level.axis(0).count);
    const auto ny = static_cast<std::uint64_t>(level.axis(1).count);
    const auto nz = Dim > 2 ? static_cast<std::uint64_t>(level.axes.back().count) : 1;
    const auto cells = [&](const IndexRange& block) {
        const auto visit = visitor();
        for (std::size_t slot = block.begin(); slot < block.end(); ++slot) {
            const std::uint32_t a0 = level.start[slot], a1 = level.start[slot + 1];
            if (a0 == a1) continue;
            const std::uint64_t key = level.key(slot);
            const std::uint64_t x = key % nx, y = key / nx % ny, z = key / nx / ny;
            // Half of the 3^Dim neighbors, row by row: each pair of cells once.
            std::array<Range, 5> rows;
            std::size_t n = 0;
            rows[n++] = level.row(key, key + (x + 1 < nx ? 1 : 0));
            const std::uint64_t left = key - (x > 0 ? 1 : 0), right = key + (x + 1 < nx ? 1 : 0);
            if (y + 1 < ny) rows[n++] = level.row(left + nx, right + nx);
            if (z + 1 < nz) {
                const std::uint64_t up = nx * ny;
                if (y > 0) rows[n++] = level.row(left + up - nx, right + up - nx);
                rows[n++] = level.row(left + up, right + up);
                if (y + 1 < ny) rows[n++] = level.row(left + up + nx, right + up + nx);
            }
            for (std::uint32_t i = a0; i < a1; ++i) {
                if (stopped()) return;
                for (std::uint32_t j = i + 1; j < rows[0].second; ++j)
                    testPair(level, i, level, j, visit);
                for (std::size_t k = 1; k < n; ++k)
                    for (std::uint32_t j = rows[k].first; j < rows[k].second; ++j)
                        testPair(level, i, level, j, visit);
            }
        }
    };
    parallelFor(IndexRange(0, level.slots(), 256), cells);
}

template <int Dim>
template <typename Visitor, typename Stopped>
void CellLevels<Dim>::pairsAcross(const Level& coarse, const Level& fine, const Visitor& visitor,
                                  const Stopped& stopped) const {
    // From each sphere of one level through the cells of the other: from the coarse ones where
    // they are few, but a coarse sphere among far smaller cells meets too many of them.
    const double across = 2 * (coarse.largestRadius / fine.largestRadius + 1) + 1;
    const double rowsACoarse =
        std::min(std::pow(across / 2, Dim - 1) + 1, static_cast<double>(fine.spheres.size()));
    const bool fromCoarse = static_cast<double>(coarse.spheres.size()) * rowsACoarse <=
                            static_cast<double>(fine.spheres.size()) * std::pow(3, Dim - 1);
    const Level& from = fromCoarse ? coarse : fine;
    const Level& through = fromCoarse ? fine : coarse;
    const auto spheres = [&](const IndexRange& block) {
        const auto visit = visitor();
        for (std::size_t k = block.begin(); k < block.end(); ++k) {
            const auto i = static_cast<std::uint32_t>(k);
            const Sphere<Dim>& s = from.spheres[i];
            // A little more than needed, so that rounding of the box loses nothing.
            const double reach = (s.radius + through.largestRadius +
                                  slack_ * std::min(s.radius, through.largestRadius)) *
                                 (1 + 1e-9);
            forEachRow(through, Box<Dim>{s.center, s.center}.grown(reach), [&](const Range& r) {
                for (std::uint32_t j = r.first; j < r.second; ++j)
                    testPair(from, i, through, j, visit);
                return !stopped();
            });
        }
    };
    parallelFor(IndexRange(0, from.spheres.size(), 16), spheres);
}

template <int Dim>
template <typename Visitor, typename Stopped>
void CellLevels<Dim>::forEachPair(const Visitor& visitor, const Stopped& stopped) const {
    for (std::size_t k = 0; k < levels_.size(); ++k) {
        pairsWithin(levels_[k], visitor, stopped);
        for (std::size_t l = k + 1; l < levels_.size(); ++l)
            pairsAcross(levels_[k], levels_[l], visitor, stopped);
    }
}

}  // namespace vdbpack
