#include "vdbpack/verify/wall_sides.h"

#include "vdbpack/core/box.h"
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

/// Rows of bins that pieces lie over at most, for each piece and each center.
constexpr double kMostRows = 4;
constexpr double kMostBinsAnAxis = 4096;

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

/// Centers in bins across an axis, and on which sides of each an odd number of pieces lies.
template <int Dim>
class Crossings {
public:
    Crossings(const std::vector<WallPiece<Dim>>& pieces, const std::vector<Sphere<Dim>>& spheres,
              int axis)
        : axis_(axis) {
        std::size_t k = 0;
        for (int i = 0; i < Dim; ++i)
            if (i != axis) across_[k++] = i;
        for (const auto& s : spheres) bounds_.add(s.center);
        chooseBins(pieces, spheres.size());
        fillBins(spheres);
        parallelFor(IndexRange(0, pieces.size(), 1024), [&](const IndexRange& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) cross(pieces[i]);
        });
    }

    /// Calls `visit(sphere, above, below)` for all: whether the pieces above its center, and those
    /// below it, are odd in number.
    template <typename Visit>
    void forEach(const Visit& visit) const {
        forAll(number_.size(), [&](std::size_t m) {
            const unsigned odd = odd_[m].load(std::memory_order_relaxed);
            visit(number_[m], (odd & kAbove) != 0, (odd & kBelow) != 0);
        });
    }

private:
    static constexpr std::uint8_t kAbove = 1, kBelow = 2;

    std::size_t clampedBin(double x, int i) const {
        const auto k = static_cast<std::size_t>(i);
        const double b = (x - bounds_.lo[across_[k]]) / binSize_[k];
        return static_cast<std::size_t>(std::clamp(b, 0.0, static_cast<double>(bins_[k] - 1)));
    }
    std::size_t binOf(const Vec<Dim>& x) const {
        return clampedBin(x[across_[0]], 0) +
               (Dim == 3 ? clampedBin(x[across_[1]], 1) * bins_[0] : 0);
    }

    /// About one bin a center, bins near square; fewer rows where large pieces lie over many.
    void chooseBins(const std::vector<WallPiece<Dim>>& pieces, std::size_t count) {
        const auto n = static_cast<double>(count);
        const Vec<Dim> size = bounds_.size();
        const double su = size[across_[0]], sv = Dim == 3 ? size[across_[1]] : 0;
        double nu = std::min(n, kMostBinsAnAxis), nv = 1;
        if (Dim == 3 && sv > 0) {
            const double extents = tbb::parallel_deterministic_reduce(
                IndexRange(0, pieces.size(), 65536), 0.0,
                [&](const IndexRange& block, double sum) {
                    for (std::size_t i = block.begin(); i < block.end(); ++i)
                        sum += boxOf<Dim>(pieces[i]).size()[across_[1]];
                    return sum;
                },
                [](double a, double b) { return a + b; });
            const double most = kMostRows * (n + static_cast<double>(pieces.size()));
            const double rows = extents > 0 ? most * sv / extents : kMostBinsAnAxis;
            nv = std::clamp(std::sqrt(su > 0 ? n * sv / su : n), 1.0,
                            std::max(1.0, std::min(rows, kMostBinsAnAxis)));
            nu = std::clamp(n / nv, 1.0, kMostBinsAnAxis);
        }
        bins_ = {static_cast<std::size_t>(nu), static_cast<std::size_t>(nv)};
        binSize_ = {su > 0 ? su / static_cast<double>(bins_[0]) : 1.0,
                    sv > 0 ? sv / static_cast<double>(bins_[1]) : 1.0};
    }

    /// Sorts the centers into the bins by counting.
    void fillBins(const std::vector<Sphere<Dim>>& spheres) {
        std::vector<std::atomic<std::uint32_t>> next(bins_[0] * bins_[1]);
        for (const auto& s : spheres) next[binOf(s.center)].fetch_add(1, std::memory_order_relaxed);
        start_ = startsOf(next);
        centers_.resize(spheres.size());
        number_.resize(spheres.size());
        odd_ = std::vector<std::atomic<std::uint8_t>>(spheres.size());
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            const std::uint32_t m =
                next[binOf(spheres[i].center)].fetch_add(1, std::memory_order_relaxed);
            centers_[m] = spheres[i].center;
            number_[m] = static_cast<std::uint32_t>(i);
        }
    }

    /// Calls `visit(first, last)` for each run of bins that a piece's shadow meets.
    template <typename Visit>
    void forEachRun(const WallPiece<Dim>& piece, const Visit& visit) const {
        const int u = across_[0];
        const Box<Dim> box = boxOf<Dim>(piece);
        if (box.hi[u] < bounds_.lo[u] || box.lo[u] > bounds_.hi[u]) return;
        // Bins are entered a little generously: rounding must not lose a crossing.
        const double margin = 1e-6 * binSize_[0];
        const std::size_t from = clampedBin(box.lo[u] - margin, 0);
        const std::size_t to = clampedBin(box.hi[u] + margin, 0);
        if constexpr (Dim == 2) {
            visit(from, to);
        } else {
            const int v = across_[1];
            if (box.hi[v] < bounds_.lo[v] || box.lo[v] > bounds_.hi[v]) return;
            const double rowMargin = 1e-6 * binSize_[1];
            const std::size_t firstRow = clampedBin(box.lo[v] - rowMargin, 1);
            const std::size_t lastRow = clampedBin(box.hi[v] + rowMargin, 1);
            for (std::size_t row = firstRow; row <= lastRow; ++row) {
                const std::size_t begin = row * bins_[0];
                if (to - from < 3) {
                    visit(begin + from, begin + to);
                    continue;
                }
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
                if (lo <= hi)
                    visit(begin + clampedBin(lo - margin, 0), begin + clampedBin(hi + margin, 0));
            }
        }
    }

    /// Counts a piece for the centers below and above it.
    void cross(const WallPiece<Dim>& piece) {
        forEachRun(piece, [&](std::size_t first, std::size_t last) {
            for (std::uint32_t m = start_[first]; m < start_[last + 1]; ++m) {
                const unsigned side = sideOf(piece, centers_[m]);
                if (side != 0)
                    odd_[m].fetch_xor(static_cast<std::uint8_t>(side), std::memory_order_relaxed);
            }
        });
    }

    /// Where a piece crosses the line through a center: kAbove, kBelow or 0, nowhere.
    unsigned sideOf(const WallPiece<Dim>& p, const Vec<Dim>& x) const {
        const int u = across_[0], w = axis_;
        double height = 0, lowest = 0, highest = 0;
        if constexpr (Dim == 2) {
            if ((p[0][u] > x[u]) == (p[1][u] > x[u])) return 0;
            height = p[0][w] + (x[u] - p[0][u]) / (p[1][u] - p[0][u]) * (p[1][w] - p[0][w]);
            lowest = std::min(p[0][w], p[1][w]);
            highest = std::max(p[0][w], p[1][w]);
        } else {
            const int v = across_[1];
            const bool s0 = p[0][v] > x[v], s1 = p[1][v] > x[v], s2 = p[2][v] > x[v];
            if (s0 == s1 && s1 == s2) return 0;
            const bool holds = (rayCrosses(x[u], x[v], p[0][u], p[0][v], p[1][u], p[1][v]) !=
                                rayCrosses(x[u], x[v], p[1][u], p[1][v], p[2][u], p[2][v])) !=
                               rayCrosses(x[u], x[v], p[2][u], p[2][v], p[0][u], p[0][v]);
            if (!holds) return 0;
            const Vec<3> n = vdbpack::cross(p[1] - p[0], p[2] - p[0]);
            lowest = std::min({p[0][w], p[1][w], p[2][w]});
            highest = std::max({p[0][w], p[1][w], p[2][w]});
            height = n[w] != 0
                         ? p[0][w] - (n[u] * (x[u] - p[0][u]) + n[v] * (x[v] - p[0][v])) / n[w]
                         : 0.5 * (lowest + highest);
        }
        // On a steep piece the quotient is noise, but its crossing lies within its own extent.
        return std::clamp(height, lowest, highest) > x[w] ? kAbove : kBelow;
    }

    int axis_;
    std::array<int, 2> across_{};  ///< the other axes; 2D: the first only
    Box<Dim> bounds_;              ///< of the centers
    std::array<std::size_t, 2> bins_{1, 1};
    std::array<double, 2> binSize_{1, 1};         ///< mm
    std::vector<std::uint32_t> start_;            ///< first center of each bin, and the end
    std::vector<Vec<Dim>> centers_;               ///< by bins
    std::vector<std::uint32_t> number_;           ///< of each among the spheres
    std::vector<std::atomic<std::uint8_t>> odd_;  ///< of each: kAbove, kBelow
};

}  // namespace

template <int Dim>
WallSides<Dim>::WallSides(const std::vector<WallPiece<Dim>>& pieces,
                          const std::vector<Sphere<Dim>>& spheres)
    : inside_(spheres.size()) {
    closed_ = tbb::parallel_reduce(
                  IndexRange(0, pieces.size(), 4096), std::uint64_t{0},
                  [&](const auto& block, std::uint64_t h) {
                      for (std::size_t i = block.begin(); i < block.end(); ++i)
                          h ^= rimHash(pieces[i]);
                      return h;
                  },
                  [](std::uint64_t a, std::uint64_t b) { return a ^ b; }) == 0;
    if (spheres.empty()) return;
    for (int axis = Dim - 1; axis >= (closed_ ? Dim - 1 : 0); --axis)
        Crossings<Dim>(pieces, spheres, axis)
            .forEach([&](std::size_t sphere, bool above, bool below) {
                inside_[sphere] =
                    static_cast<std::uint8_t>(inside_[sphere] + above + (!closed_ && below));
            });
    if (!closed_)
        for (std::uint8_t& votes : inside_) votes = votes > Dim;
}

template class WallSides<2>;
template class WallSides<3>;

}  // namespace vdbpack
