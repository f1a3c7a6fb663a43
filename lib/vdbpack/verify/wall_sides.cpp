#include "vdbpack/verify/wall_sides.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/verify/counting.h"
#include "vdbpack/verify/mix.h"

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Entries of bins a piece, on average: over a foam lie so many layers of pieces that one bin a
/// piece is far smaller than a piece.
constexpr std::size_t kMostEntries = 10;
constexpr double kMostBinsAnAxis = 4096;  // bounds the rows that a large triangle is cut into

template <int Dim>
std::uint64_t cornerHash(const Vec<Dim>& p) {
    std::uint64_t h = kHashStart;
    for (int i = 0; i < Dim; ++i) h = mixedBits(h ^ bitsOfNumber(p[i])) + kHashStart;
    return h;
}

/// Exclusive-or of a hash of every edge (2D: end): zero if each occurs an even number of times,
/// and otherwise with a probability of 2^-64.
std::uint64_t rimHash(const WallPiece<2>& piece) {
    return piece[0] == piece[1] ? 0 : cornerHash(piece[0]) ^ cornerHash(piece[1]);
}
std::uint64_t rimHash(const WallPiece<3>& piece) {
    const std::array<std::uint64_t, 3> h{cornerHash(piece[0]), cornerHash(piece[1]),
                                         cornerHash(piece[2])};
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < 3; ++i)
        if (h[i] != h[(i + 1) % 3]) sum ^= mixedBits(h[i] + h[(i + 1) % 3]);
    return sum;
}

/// Whether the ray from p along the first of two axes crosses the edge ab. Computed from the lower
/// to the upper end, so that the answer is the same in every piece that has this edge.
bool rayCrosses(double px, double py, double ax, double ay, double bx, double by) {
    if ((ay > py) == (by > py)) return false;
    if (ay > by) {
        std::swap(ax, bx);
        std::swap(ay, by);
    }
    return ax + (py - ay) / (by - ay) * (bx - ax) > px;
}

}  // namespace

template <int Dim>
std::size_t WallCrossings<Dim>::clampedBin(double x, int i) const {
    const auto k = static_cast<std::size_t>(i);
    const double b = (x - bounds_.lo[across_[k]]) / binSize_[k];
    return static_cast<std::size_t>(std::clamp(b, 0.0, static_cast<double>(bins_[k] - 1)));
}

template <int Dim>
template <typename Work>
void WallCrossings<Dim>::forAllPieces(const Work& work) const {
    parallelFor(IndexRange(0, pieces_.size(), 1024), [&](const IndexRange& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i)
            if (!work(i)) return;
    });
}

template <int Dim>
template <typename Visit>
void WallCrossings<Dim>::forEachRun(const WallPiece<Dim>& piece, const Visit& visit) const {
    const int u = across_[0], v = across_[1];
    const Box<Dim> box = boxOf<Dim>(piece);
    // Bins are entered a little generously: rounding must not lose a crossing.
    const double margin = 1e-6 * binSize_[0];
    if constexpr (Dim == 2) {
        visit(clampedBin(box.lo[u] - margin, 0), clampedBin(box.hi[u] + margin, 0));
    } else {
        const double rowMargin = 1e-6 * binSize_[1];
        const std::size_t lastRow = clampedBin(box.hi[v] + rowMargin, 1);
        for (std::size_t row = clampedBin(box.lo[v] - rowMargin, 1); row <= lastRow; ++row) {
            // The part of the shadow between the sides of this row, by its extent along u.
            const double side = bounds_.lo[v] + static_cast<double>(row) * binSize_[1];
            const double v0 =
                row == 0 ? -std::numeric_limits<double>::infinity() : side - rowMargin;
            const double v1 = row + 1 == bins_[1] ? std::numeric_limits<double>::infinity()
                                                  : side + binSize_[1] + rowMargin;
            double lo = std::numeric_limits<double>::infinity(), hi = -lo;
            for (std::size_t k = 0; k < piece.size(); ++k) {
                const Vec<Dim>&a = piece[k], &b = piece[(k + 1) % piece.size()];
                if (a[v] >= v0 && a[v] <= v1) {
                    lo = std::min(lo, a[u]);
                    hi = std::max(hi, a[u]);
                }
                for (const double cut : {v0, v1}) {
                    if ((a[v] < cut) == (b[v] < cut)) continue;
                    const double at = a[u] + (cut - a[v]) / (b[v] - a[v]) * (b[u] - a[u]);
                    lo = std::min(lo, at);
                    hi = std::max(hi, at);
                }
            }
            if (lo > hi) continue;
            visit(row * bins_[0] + clampedBin(lo - margin, 0),
                  row * bins_[0] + clampedBin(hi + margin, 0));
        }
    }
}

template <int Dim>
WallCrossings<Dim>::WallCrossings(const std::vector<WallPiece<Dim>>& pieces, int axis)
    : pieces_(pieces), axis_(axis) {
    std::size_t k = 0;
    for (int i = 0; i < Dim; ++i)
        if (i != axis) across_[k++] = i;
    for (const auto& piece : pieces)
        for (const auto& p : piece) bounds_.add(p);
    chooseBins();
    fillBins();
}

/// About one bin a piece, bins near square; fewer where large pieces meet too many of them.
template <int Dim>
void WallCrossings<Dim>::chooseBins() {
    const double n = static_cast<double>(pieces_.size());
    const Vec<Dim> size = bounds_.size();
    const double su = size[across_[0]], sv = Dim == 3 ? size[across_[1]] : 0;
    double nu = n, nv = 1;
    if (Dim == 3) {
        const double aspect = su > 0 && sv > 0 ? su / sv : 1;
        nu = std::clamp(std::sqrt(n * aspect), 1.0, kMostBinsAnAxis);
        nv = std::clamp(n / nu, 1.0, kMostBinsAnAxis);
    }
    for (;;) {
        bins_ = {static_cast<std::size_t>(nu), static_cast<std::size_t>(nv)};
        binSize_ = {su > 0 ? su / static_cast<double>(bins_[0]) : 1.0,
                    sv > 0 ? sv / static_cast<double>(bins_[1]) : 1.0};
        // Rows count like entries and counting ends at the limit: a mesh of nothing but giant
        // triangles must not cost the product of triangles and rows.
        const std::size_t most = kMostEntries * pieces_.size() + 1024;
        std::atomic<std::size_t> entries{0};
        forAllPieces([&](std::size_t i) {
            if (i % 64 == 0 && entries.load(std::memory_order_relaxed) > most) return false;
            std::size_t sum = 0;
            forEachRun(pieces_[i],
                       [&](std::size_t first, std::size_t last) { sum += last - first + 1; });
            entries.fetch_add(sum, std::memory_order_relaxed);
            return true;
        });
        if (entries <= most || bins_[0] * bins_[1] == 1) return;
        nu = std::max(1.0, nu / 2);
        nv = std::max(1.0, nv / 2);
    }
}

/// Sorts the pieces into the bins by counting.
template <int Dim>
void WallCrossings<Dim>::fillBins() {
    std::vector<std::atomic<std::uint32_t>> next(bins_[0] * bins_[1]);
    forAllPieces([&](std::size_t i) {
        forEachRun(pieces_[i], [&](std::size_t first, std::size_t last) {
            for (std::size_t b = first; b <= last; ++b)
                next[b].fetch_add(1, std::memory_order_relaxed);
        });
        return true;
    });
    start_ = startsOf(next);
    members_.resize(start_.back());
    forAllPieces([&](std::size_t i) {
        forEachRun(pieces_[i], [&](std::size_t first, std::size_t last) {
            for (std::size_t b = first; b <= last; ++b)
                members_[next[b].fetch_add(1, std::memory_order_relaxed)] =
                    static_cast<std::uint32_t>(i);
        });
        return true;
    });
}

template <int Dim>
typename WallCrossings<Dim>::Count WallCrossings<Dim>::count(const Vec<Dim>& x) const {
    Count result;
    const int u = across_[0], v = across_[1], w = axis_;
    if (!(x[u] >= bounds_.lo[u] && x[u] <= bounds_.hi[u])) return result;
    if (Dim == 3 && !(x[v] >= bounds_.lo[v] && x[v] <= bounds_.hi[v])) return result;
    const std::size_t bin = clampedBin(x[u], 0) + (Dim == 3 ? clampedBin(x[v], 1) * bins_[0] : 0);
    for (std::uint32_t m = start_[bin]; m < start_[bin + 1]; ++m) {
        const WallPiece<Dim>& p = pieces_[members_[m]];
        double height = 0, lowest = 0, highest = 0;
        if constexpr (Dim == 2) {
            if ((p[0][u] > x[u]) == (p[1][u] > x[u])) continue;
            height = p[0][w] + (x[u] - p[0][u]) / (p[1][u] - p[0][u]) * (p[1][w] - p[0][w]);
            lowest = std::min(p[0][w], p[1][w]);
            highest = std::max(p[0][w], p[1][w]);
        } else {
            const bool s0 = p[0][v] > x[v], s1 = p[1][v] > x[v], s2 = p[2][v] > x[v];
            if (s0 == s1 && s1 == s2) continue;
            const bool holds = (rayCrosses(x[u], x[v], p[0][u], p[0][v], p[1][u], p[1][v]) !=
                                rayCrosses(x[u], x[v], p[1][u], p[1][v], p[2][u], p[2][v])) !=
                               rayCrosses(x[u], x[v], p[2][u], p[2][v], p[0][u], p[0][v]);
            if (!holds) continue;
            const Vec<3> n = cross(p[1] - p[0], p[2] - p[0]);
            lowest = std::min({p[0][w], p[1][w], p[2][w]});
            highest = std::max({p[0][w], p[1][w], p[2][w]});
            height = n[w] != 0
                         ? p[0][w] - (n[u] * (x[u] - p[0][u]) + n[v] * (x[v] - p[0][v])) / n[w]
                         : 0.5 * (lowest + highest);
        }
        // On a steep piece the quotient is noise, but its crossing lies within its own extent.
        if (std::clamp(height, lowest, highest) > x[w])
            ++result.above;
        else
            ++result.below;
    }
    return result;
}

template <int Dim>
WallSides<Dim>::WallSides(const std::vector<WallPiece<Dim>>& pieces) {
    closed_ = tbb::parallel_reduce(
                  IndexRange(0, pieces.size(), 4096), std::uint64_t{0},
                  [&](const auto& block, std::uint64_t h) {
                      for (std::size_t i = block.begin(); i < block.end(); ++i)
                          h ^= rimHash(pieces[i]);
                      return h;
                  },
                  [](std::uint64_t a, std::uint64_t b) { return a ^ b; }) == 0;
    for (int axis = Dim - 1; axis >= (closed_ ? Dim - 1 : 0); --axis)
        axes_.emplace_back(pieces, axis);
}

template <int Dim>
bool WallSides<Dim>::inside(const Vec<Dim>& x) const {
    if (closed_) return axes_.front().count(x).above % 2 != 0;
    int votes = 0;
    for (const auto& axis : axes_) {
        const auto c = axis.count(x);
        votes += c.above % 2 + c.below % 2;
    }
    return votes > Dim;
}

template class WallCrossings<2>;
template class WallCrossings<3>;
template class WallSides<2>;
template class WallSides<3>;

}  // namespace vdbpack
