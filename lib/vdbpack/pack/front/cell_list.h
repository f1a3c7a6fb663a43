// The spheres in and around one block, by cell.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/lanes.h"
#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace vdbpack {

/// A cell list that grows while a block is filled. Spheres that are far larger than most lie on
/// coarser levels, so that they do not widen the search for the others. Coordinates are the
/// caller's; keep them small (relative to the block), since they are stored as float for searching.
template <int Dim>
class CellList {
public:
    /// Empties the list and lays cells of edge `cell` (mm) over `bounds`.
    /// @param common  radius up to which spheres lie on the finest level, mm.
    /// @param graded  whether spheres up to the largest are many somewhere: then levels are finer,
    ///                and their cells hold about as many spheres each.
    void reset(const Box<Dim>& bounds, double cell, double common, bool graded = false) {
        bounds_ = bounds;
        overflow_.clear();
        used_ = 0;
        graded_ = graded;
        addLevel(cell, common);
    }

    /// Adds sphere `index`; outside the bounds it is kept in the nearest cell, where a search
    /// that reaches it looks as well.
    void add(const Sphere<Dim>& s, std::uint32_t index) {
        std::size_t l = 0;
        for (; s.radius > levels_[l].maxRadius; ++l)
            if (l + 1 == used_) addCoarserLevel(levels_[l]);
        Level& level = levels_[l];
        std::size_t cell = 0;
        for (int d = Dim - 1; d >= 0; --d) {
            const int at = coordinate(level, s.center[d], d);
            level.low[d] = std::min(level.low[d], at);
            level.high[d] = std::max(level.high[d], at);
            cell = cell * static_cast<std::size_t>(level.n[d]) + static_cast<std::size_t>(at);
        }
        const std::uint32_t count = level.count[cell]++;
        const std::uint32_t at = count % kChunk;
        if (at == 0 && count >= kOwnChunks * kChunk) {
            overflow_.emplace_back();
            overflow_.back().next = count == kOwnChunks * kChunk ? kNone : level.overflow[cell];
            level.overflow[cell] = static_cast<std::uint32_t>(overflow_.size() - 1);
        }
        Chunk& c = count < kOwnChunks * kChunk ? level.chunks[cell * kOwnChunks + count / kChunk]
                                               : overflow_[level.overflow[cell]];
        if (at == 0) c.radius.fill(kUnused);
        for (int d = 0; d < Dim; ++d)
            c.x[static_cast<std::size_t>(d)][at] = static_cast<float>(s.center[d]);
        c.radius[at] = static_cast<float>(s.radius);
        c.index[at] = index;
    }

    /// Calls `visit(index)` for every sphere that may have a gap smaller than `reach` to `x`:
    /// all that do, and some that miss it by rounding. `visit` returns false to stop.
    template <class Visit>
    bool near(const Vec<Dim>& x, double reach, Visit visit) const {
        return forEachChunk(x, reach, [&](const Chunk& c, const auto&, Int8 inside) {
            bool on = true;
            forEachSet(inside, [&](std::size_t l) { on = on && visit(c.index[l]); });
            return on;
        });
    }

    /// Spheres around a point, as arrays of equal length padded to whole lanes with spheres that
    /// are far away and have no radius.
    struct Around {
        std::array<std::vector<float>, Dim> to;  ///< centers, from the point
        std::vector<float> radius;
        std::vector<std::uint32_t> index;
        std::size_t count = 0;

        void append(const std::array<float, Dim>& center, float r, std::uint32_t i) {
            resize(count + 1);
            if (count % kLanes == 0) clear(count, count + kLanes);  // left from another point
            for (std::size_t d = 0; d < Dim; ++d) to[d][count] = center[d];
            radius[count] = r;
            index[count++] = i;
        }
        /// Room for `n` spheres and the padding.
        void resize(std::size_t n) {
            if (padded(n) <= index.size()) return;
            for (auto& v : to) v.resize(padded(n), kFar);
            radius.resize(padded(n), 0.0f);
            index.resize(padded(n), 0);
        }
        void pad() {
            resize(count);
            clear(count, padded(count));
        }
        void clear(std::size_t from, std::size_t end) {
            for (std::size_t l = from; l < end; ++l) {
                for (auto& v : to) v[l] = kFar;
                radius[l] = 0;
            }
        }
        static constexpr float kFar = 1e18f;
    };

    /// The spheres that `near` finds, without sphere `except`.
    void collect(const Vec<Dim>& x, double reach, std::uint32_t except, Around& around) const {
        around.count = 0;
        forEachChunk(x, reach, [&](const Chunk& c, const std::array<Float8, Dim>& to, Int8 inside) {
            around.resize(around.count + 2 * kLanes);
            Word8 index;
            std::memcpy(&index, c.index.data(), sizeof index);
            const LanePacking packed(bitsOf(inside & (index != except)));
            const std::size_t n = around.count;
            for (std::size_t d = 0; d < Dim; ++d) store(&around.to[d][n], packed(to[d]));
            store(&around.radius[n], packed(load(c.radius.data())));
            store(&around.index[n], packed(index));
            around.count += packed.count();
            return true;
        });
        around.pad();
    }

private:
    static constexpr std::uint32_t kChunk = kLanes;
    static constexpr std::uint32_t kNone = 0xffffffffu;
    /// Chunks that lie in the order of the cells, so that neighbors are read in a row; cells that
    /// hold more are few.
    static constexpr std::uint32_t kOwnChunks = 2;
    /// A radius that no reach makes up for.
    static constexpr float kUnused = -1e18f;
    struct Chunk {
        std::array<std::array<float, kChunk>, Dim> x;
        std::array<float, kChunk> radius;
        std::array<std::uint32_t, kChunk> index;
        std::uint32_t next;  ///< of the same cell, in `overflow_`
    };

    /// Each level holds spheres up to this many times as large as the one before.
    static constexpr double kNextLevel = 4, kNextGradedLevel = 2;
    struct Level {
        double maxRadius = 0, inverse = 1;
        int n[3] = {1, 1, 1};
        int low[3] = {0, 0, 0}, high[3] = {0, 0, 0};  ///< cells in use lie between these
        std::vector<std::uint32_t> count;             ///< of spheres in each cell
        std::vector<std::uint32_t> overflow;          ///< its last chunk there, if it has any
        std::vector<Chunk> chunks;                    ///< kOwnChunks of each cell
    };

    void addCoarserLevel(const Level& level) {
        const double maxRadius = level.maxRadius;
        if (graded_)
            addLevel(kNextGradedLevel / level.inverse, kNextGradedLevel * maxRadius);
        else
            addLevel(2 * kNextLevel * maxRadius, kNextLevel * maxRadius);
    }

    void addLevel(double cell, double maxRadius) {
        if (levels_.size() == used_) levels_.emplace_back();
        Level& level = levels_[used_++];
        level.maxRadius = maxRadius;
        level.inverse = 1.0 / cell;
        std::size_t total = 1;
        for (int d = 0; d < Dim; ++d) {
            level.n[d] = std::max(
                1, static_cast<int>(std::ceil((bounds_.hi[d] - bounds_.lo[d]) * level.inverse)));
            level.low[d] = level.n[d];
            level.high[d] = -1;
            total *= static_cast<std::size_t>(level.n[d]);
        }
        level.count.assign(total, 0);
        level.overflow.resize(total);
        if (level.chunks.size() < total * kOwnChunks) level.chunks.resize(total * kOwnChunks);
    }

    /// Calls `visit(chunk, centers from x, which are in reach)` until it returns false.
    template <class Visit>
    bool forEachChunk(const Vec<Dim>& x, double reach, Visit visit) const {
        std::array<float, Dim> at;
        for (int d = 0; d < Dim; ++d) at[static_cast<std::size_t>(d)] = static_cast<float>(x[d]);
        for (std::size_t l = 0; l < used_; ++l) {
            const Level& level = levels_[l];
            const double far = reach + level.maxRadius;
            int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
            for (int d = 0; d < Dim; ++d) {
                from[d] = std::max(coordinate(level, x[d] - far, d), level.low[d]);
                to[d] = std::min(coordinate(level, x[d] + far, d), level.high[d]);
            }
            const auto r = static_cast<float>(reach + 1e-5 * (std::fabs(reach) + level.maxRadius));
            const auto look = [&](const Chunk& c) {
                std::array<Float8, Dim> away;
                Float8 square{};
                for (std::size_t d = 0; d < Dim; ++d) {
                    away[d] = load(c.x[d].data()) - at[d];
                    square += away[d] * away[d];
                }
                const Float8 limit = larger(load(c.radius.data()) + r, 0.0f);
                const Int8 inside = square < limit * limit;
                return noneOf(inside) || visit(c, away, inside);
            };
            for (int k = from[2]; k <= to[2]; ++k)
                for (int j = from[1]; j <= to[1]; ++j) {
                    const std::size_t row =
                        (static_cast<std::size_t>(k) * static_cast<std::size_t>(level.n[1]) +
                         static_cast<std::size_t>(j)) *
                        static_cast<std::size_t>(level.n[0]);
                    for (int i = from[0]; i <= to[0]; ++i) {
                        const std::size_t cell = row + static_cast<std::size_t>(i);
                        const std::uint32_t count = level.count[cell];
                        if (count > kOwnChunks * kChunk)
                            for (std::uint32_t q = level.overflow[cell]; q != kNone;
                                 q = overflow_[q].next)
                                if (!look(overflow_[q])) return false;
                        const Chunk* own = &level.chunks[cell * kOwnChunks];
                        for (std::uint32_t n = std::min((count + kChunk - 1) / kChunk, kOwnChunks);
                             n-- > 0;)
                            if (!look(own[n])) return false;
                    }
                }
        }
        return true;
    }

    int coordinate(const Level& level, double x, int d) const {
        const double c = (x - bounds_.lo[d]) * level.inverse;
        return c <= 0 ? 0 : c >= level.n[d] ? level.n[d] - 1 : static_cast<int>(c);
    }

    Box<Dim> bounds_;
    std::vector<Level> levels_;
    std::size_t used_ = 0;  ///< levels in use; the others keep their memory
    bool graded_ = false;
    std::vector<Chunk> overflow_;
};

}  // namespace vdbpack
