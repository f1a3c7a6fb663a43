// The spheres in and around one block, by cell.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A uniform cell list that grows while a block is filled. Coordinates are the caller's;
/// keep them small (relative to the block), since they are stored as float for searching.
template <int Dim>
class CellList {
public:
    /// Empties the list and lays cells of edge `cell` (mm) over `bounds`.
    void reset(const Box<Dim>& bounds, double cell) {
        lo_ = bounds.lo;
        inverse_ = 1.0 / cell;
        std::size_t total = 1;
        for (int d = 0; d < Dim; ++d) {
            n_[d] = std::max(1, static_cast<int>(std::ceil((bounds.hi[d] - lo_[d]) * inverse_)));
            total *= static_cast<std::size_t>(n_[d]);
        }
        head_.assign(total, kNone);
        chunks_.clear();
    }

    /// Adds sphere `index`; outside the bounds it is kept in the nearest cell, where a search
    /// that reaches it looks as well.
    void add(const Sphere<Dim>& s, std::uint32_t index) {
        std::size_t cell = 0;
        for (int d = Dim - 1; d >= 0; --d)
            cell = cell * static_cast<std::size_t>(n_[d]) +
                   static_cast<std::size_t>(coordinate(s.center[d], d));
        std::uint32_t& head = head_[cell];
        if (head == kNone || chunks_[head].count == kChunk) {
            chunks_.emplace_back();
            chunks_.back().next = head;
            head = static_cast<std::uint32_t>(chunks_.size() - 1);
        }
        Chunk& c = chunks_[head];
        for (int d = 0; d < Dim; ++d)
            c.x[static_cast<std::size_t>(d)][c.count] = static_cast<float>(s.center[d]);
        c.radius[c.count] = static_cast<float>(s.radius);
        c.index[c.count++] = index;
    }

    /// Calls `visit(index)` for every sphere that may have a gap smaller than `reach` to `x`:
    /// all that do, and some that miss it by rounding. `maxRadius` bounds the radii added.
    /// `visit` returns false to stop.
    template <class Visit>
    bool near(const Vec<Dim>& x, double reach, double maxRadius, Visit visit) const {
        return forEachChunk(x, reach, maxRadius, [&](const Chunk& c, const auto&, auto inside) {
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

    /// The spheres that `near` finds, but for sphere `except`.
    void collect(const Vec<Dim>& x, double reach, double maxRadius, std::uint32_t except,
                 Around& around) const {
        around.count = 0;
        forEachChunk(x, reach, maxRadius,
                     [&](const Chunk& c, const std::array<Lanes, Dim>& to, auto inside) {
                         around.resize(around.count + 2 * kLanes);
                         float away[Dim][kLanes];
                         for (std::size_t d = 0; d < Dim; ++d)
                             to[d].copy_to(away[d], stdx::element_aligned);
                         forEachSet(inside, [&](std::size_t l) {
                             const std::size_t n = around.count;
                             for (std::size_t d = 0; d < Dim; ++d) around.to[d][n] = away[d][l];
                             around.radius[n] = c.radius[l];
                             around.index[n] = c.index[l];
                             around.count += c.index[l] != except ? 1 : 0;
                         });
                         return true;
                     });
        around.pad();
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::uint32_t kChunk = kLanes;
    struct Chunk {
        std::array<std::array<float, kChunk>, Dim> x{};
        std::array<float, kChunk> radius = unused();
        std::array<std::uint32_t, kChunk> index;
        std::uint32_t count = 0;
        std::uint32_t next = kNone;

        static std::array<float, kChunk> unused() {
            std::array<float, kChunk> r;
            r.fill(-1e18f);
            return r;
        }
    };

    /// Calls `visit(chunk, centers from x, which are in reach)` until it returns false.
    template <class Visit>
    bool forEachChunk(const Vec<Dim>& x, double reach, double maxRadius, Visit visit) const {
        int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
        std::array<Lanes, Dim> at;
        for (int d = 0; d < Dim; ++d) {
            from[d] = coordinate(x[d] - reach - maxRadius, d);
            to[d] = coordinate(x[d] + reach + maxRadius, d);
            at[static_cast<std::size_t>(d)] = static_cast<float>(x[d]);
        }
        const Lanes r = static_cast<float>(reach + 1e-5 * (std::fabs(reach) + maxRadius));
        for (int k = from[2]; k <= to[2]; ++k)
            for (int j = from[1]; j <= to[1]; ++j) {
                const std::size_t row =
                    (static_cast<std::size_t>(k) * static_cast<std::size_t>(n_[1]) +
                     static_cast<std::size_t>(j)) *
                    static_cast<std::size_t>(n_[0]);
                for (int i = from[0]; i <= to[0]; ++i)
                    for (std::uint32_t q = head_[row + static_cast<std::size_t>(i)]; q != kNone;
                         q = chunks_[q].next) {
                        const Chunk& c = chunks_[q];
                        std::array<Lanes, Dim> away;
                        Lanes square = 0.0f;
                        for (std::size_t d = 0; d < Dim; ++d) {
                            away[d] = load(c.x[d].data()) - at[d];
                            square += away[d] * away[d];
                        }
                        // Lanes not in use have a radius that no reach makes up for.
                        const Lanes limit = stdx::max(load(c.radius.data()) + r, Lanes(0.0f));
                        const auto inside = square < limit * limit;
                        if (any_of(inside) && !visit(c, away, inside)) return false;
                    }
            }
        return true;
    }

    int coordinate(double x, int d) const {
        const double c = (x - lo_[d]) * inverse_;
        return c <= 0 ? 0 : c >= n_[d] ? n_[d] - 1 : static_cast<int>(c);
    }

    Vec<Dim> lo_;
    double inverse_ = 1;
    int n_[3] = {1, 1, 1};
    std::vector<std::uint32_t> head_;
    std::vector<Chunk> chunks_;
};

}  // namespace vdbpack
