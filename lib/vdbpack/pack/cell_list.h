// The spheres in and around one block, by cell.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <experimental/simd>
#include <vector>

namespace vdbpack {

namespace stdx = std::experimental;

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
                        Lanes square = 0.0f;
                        for (std::size_t d = 0; d < Dim; ++d) {
                            const Lanes away = Lanes(c.x[d].data(), stdx::element_aligned) - at[d];
                            square += away * away;
                        }
                        const Lanes limit = stdx::max(
                            Lanes(c.radius.data(), stdx::element_aligned) + r, Lanes(0.0f));
                        const Lanes inside = limit * limit - square;
                        if (none_of(inside > 0.0f)) continue;
                        float value[kChunk];
                        inside.copy_to(value, stdx::element_aligned);
                        for (std::uint32_t l = 0; l < c.count; ++l)
                            if (value[l] > 0.0f && !visit(c.index[l])) return false;
                    }
            }
        return true;
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr std::uint32_t kChunk = 8;
    using Lanes = stdx::fixed_size_simd<float, kChunk>;
    struct Chunk {
        std::array<std::array<float, kChunk>, Dim> x{};
        std::array<float, kChunk> radius{};
        std::array<std::uint32_t, kChunk> index;
        std::uint32_t count = 0;
        std::uint32_t next = kNone;
    };

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
