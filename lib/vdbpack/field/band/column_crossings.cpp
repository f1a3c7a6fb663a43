#include "vdbpack/field/band/column_crossings.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

constexpr int kFractionBits = 24;
constexpr std::int64_t kOne = std::int64_t{1} << kFractionBits;
/// Up to this extent (voxels) products of two differences fit into 64 bits.
constexpr std::int64_t kNarrow = 64;
__extension__ using Wide = __int128;

struct Corner {
    std::int64_t x, y;  ///< in 2^-24 voxel
    double z;           ///< in voxels
};

std::int64_t rounded(double v) {
    return static_cast<std::int64_t>(std::nearbyint(v * static_cast<double>(kOne)));
}
std::int64_t ceilOf(std::int64_t v) {
    return (v + kOne - 1) >> kFractionBits;
}
std::int64_t floorOf(std::int64_t v) {
    return v >> kFractionBits;
}

/// Twice the signed area of (a, b, p), and the side of p if it is moved by (e, e^2).
template <class Integer>
struct Side {
    Side(const Corner& a, const Corner& b, std::int64_t px, std::int64_t py)
        : area(static_cast<Integer>(b.x - a.x) * (py - a.y) -
               static_cast<Integer>(b.y - a.y) * (px - a.x)),
          left(area != 0    ? area > 0
               : b.y != a.y ? b.y < a.y
                            : b.x > a.x) {}
    Integer area;
    bool left;
};

template <class Integer, class Visit>
void rasterizeWith(const std::array<Corner, 3>& c, const Visit& visit) {
    const auto [xLow, xHigh] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [yLow, yHigh] = std::minmax({c[0].y, c[1].y, c[2].y});
    const Integer twice = static_cast<Integer>(c[1].x - c[0].x) * (c[2].y - c[0].y) -
                          static_cast<Integer>(c[1].y - c[0].y) * (c[2].x - c[0].x);
    if (twice == 0) return;
    const std::int64_t x0 = ceilOf(xLow), x1 = floorOf(xHigh);
    for (std::int64_t y = ceilOf(yLow); y <= floorOf(yHigh); ++y) {
        const std::int64_t py = y * kOne;
        std::int64_t from = x0, to = x1;
        if (to - from > 8) {
            // The part of the row between the sides, with a voxel to spare on both ends.
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (std::size_t k = 0; k < 3; ++k) {
                const Corner &a = c[k], &b = c[(k + 1) % 3];
                if (std::min(a.y, b.y) > py || std::max(a.y, b.y) < py) continue;
                for (const Corner* end : {&a, &b})
                    if (a.y == b.y) {
                        low = std::min(low, static_cast<double>(end->x));
                        high = std::max(high, static_cast<double>(end->x));
                    }
                if (a.y == b.y) continue;
                const double t = static_cast<double>(py - a.y) / static_cast<double>(b.y - a.y);
                const double x = static_cast<double>(a.x) + t * static_cast<double>(b.x - a.x);
                low = std::min(low, x);
                high = std::max(high, x);
            }
            if (!(low <= high)) continue;
            from = std::max(from, floorOf(static_cast<std::int64_t>(low)) - 1);
            to = std::min(to, floorOf(static_cast<std::int64_t>(high)) + 2);
        }
        for (std::int64_t x = from; x <= to; ++x) {
            const std::int64_t px = x * kOne;
            const Side<Integer> s0(c[1], c[2], px, py), s1(c[2], c[0], px, py),
                s2(c[0], c[1], px, py);
            if (s0.left != s1.left || s1.left != s2.left) continue;
            // A mean with positive weights: as exact where the triangle is steep.
            const double w0 = static_cast<double>(s0.area), w1 = static_cast<double>(s1.area),
                         w2 = static_cast<double>(s2.area);
            const double z = (w0 * c[0].z + w1 * c[1].z + w2 * c[2].z) / (w0 + w1 + w2);
            visit(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                  static_cast<std::int32_t>(std::floor(z)) + 1);
        }
    }
}

/// Calls `visit(x, y, z)` for the lines (x, y) that cross the triangle; z is the first lattice
/// point above the crossing.
template <class Visit>
void rasterize(const std::array<Corner, 3>& c, const Visit& visit) {
    const auto [xLow, xHigh] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [yLow, yHigh] = std::minmax({c[0].y, c[1].y, c[2].y});
    if (std::max(xHigh - xLow, yHigh - yLow) < kNarrow * kOne)
        rasterizeWith<std::int64_t>(c, visit);
    else
        rasterizeWith<Wide>(c, visit);
}

}  // namespace

ColumnCrossings::ColumnCrossings(const BandMesh& mesh, const Callbacks& callbacks) {
    const auto& triangles = *mesh.triangles;
    if (triangles.empty()) return;
    const Vec<3>&lo = mesh.bounds.lo, &hi = mesh.bounds.hi;
    x0_ = static_cast<std::int32_t>(std::floor(lo[0]));
    y0_ = static_cast<std::int32_t>(std::floor(lo[1]));
    columns_ = static_cast<std::int32_t>(std::ceil(hi[0])) - x0_ + 1;
    rows_ = static_cast<std::int32_t>(std::ceil(hi[1])) - y0_ + 1;
    const std::size_t lines = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    if (lines >= std::size_t{1} << 32)
        throw ResourceError(
            fmt::format("the field would have {} by {} lines of voxels; give a larger `voxelSize`",
                        columns_, rows_));
    const auto cornersOf = [&](std::size_t i) {
        std::array<Corner, 3> c;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec<3>& v = mesh.corner(i, k);
            c[k] = {rounded(v[0]), rounded(v[1]), v[2]};
        }
        return c;
    };
    std::vector<std::atomic<std::uint32_t>> next(lines);
    // Of a fine mesh, few triangles cross a line.
    PerThread<std::vector<std::uint32_t>> crossing;
    parallelFor(IndexRange(0, triangles.size(), 4096), [&](const IndexRange& part) {
        auto& mine = crossing.local();
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            bool any = false;
            rasterize(cornersOf(i), [&](std::int32_t x, std::int32_t y, std::int32_t) {
                any = true;
                next[columnOf(x, y)].fetch_add(1, std::memory_order_relaxed);
            });
            if (any) mine.push_back(static_cast<std::uint32_t>(i));
        }
    });
    callbacks.stopIfCancelled();
    above_.resize(firstPositions(next, start_, "crossings of lines of voxels with the mesh",
                                 "give a larger `voxelSize`"));
    for (const auto& mine : crossing)
        forAll(mine.size(), [&](std::size_t i) {
            rasterize(cornersOf(mine[i]), [&](std::int32_t x, std::int32_t y, std::int32_t z) {
                above_[next[columnOf(x, y)].fetch_add(1, std::memory_order_relaxed)] = z;
            });
        });
    callbacks.stopIfCancelled();
    forAll(lines, [&](std::size_t i) {
        std::sort(above_.begin() + start_[i], above_.begin() + start_[i + 1]);
    });
}

bool ColumnCrossings::inside(std::int32_t x, std::int32_t y, std::int32_t z) const {
    if (!covers(x, y)) return false;
    const std::size_t column = columnOf(x, y);
    const auto first = above_.begin() + start_[column], last = above_.begin() + start_[column + 1];
    return (std::upper_bound(first, last, z) - first) % 2 == 1;
}

unsigned ColumnCrossings::insideOfEight(std::int32_t x, std::int32_t y, std::int32_t z) const {
    if (!covers(x, y)) return 0;
    const std::size_t column = columnOf(x, y);
    unsigned bits = 0;
    for (std::uint32_t k = start_[column]; k < start_[column + 1]; ++k) {
        if (above_[k] > z + 7) break;
        bits ^= above_[k] <= z ? 0xffu : 0xffu << (above_[k] - z);
    }
    return bits & 0xffu;
}

}  // namespace vdbpack
