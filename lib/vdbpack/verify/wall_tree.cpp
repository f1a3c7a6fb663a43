#include "vdbpack/verify/wall_tree.h"

#include "vdbpack/core/rng.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

namespace vdbpack {

namespace {

constexpr std::uint32_t kLeafPieces = 4;
constexpr double kMostBinsAnAxis = 4096;  // bounds the rows that a large triangle is cut into

float below(double v) {
    return std::nextafter(static_cast<float>(v), -std::numeric_limits<float>::infinity());
}
float above(double v) {
    return std::nextafter(static_cast<float>(v), std::numeric_limits<float>::infinity());
}

template <int Dim>
Box<Dim> boxOf(const WallPiece<Dim>& piece) {
    Box<Dim> b;
    for (const auto& p : piece) b.add(p);
    return b;
}

/// Nodes of a subtree over `n` pieces; its shape depends on `n` alone, so that both halves can be
/// written to their places at the same time.
std::uint32_t nodeCount(std::uint32_t n) {
    return n <= kLeafPieces ? 1 : 1 + nodeCount(n / 2) + nodeCount(n - n / 2);
}

std::uint64_t bitsOf(double v) {
    v += 0.0;  // -0 and 0 are one corner
    std::uint64_t b;
    std::memcpy(&b, &v, sizeof b);
    return b;
}

template <int Dim>
std::uint64_t cornerHash(const Vec<Dim>& p) {
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    for (int i = 0; i < Dim; ++i) h = mix64(h ^ bitsOf(p[i])) + 0x9e3779b97f4a7c15ull;
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
        if (h[i] != h[(i + 1) % 3]) sum ^= mix64(h[i] + h[(i + 1) % 3]);
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
double squaredDistanceToSegment(const Vec<Dim>& x, const Vec<Dim>& a, const Vec<Dim>& b) {
    const Vec<Dim> e = b - a, d = x - a;
    const double ee = dot(e, e), de = dot(d, e);
    if (!(de > 0) || !(ee > 0)) return squaredLength(d);
    if (de >= ee) return squaredLength(x - b);
    return squaredLength(d - e * (de / ee));
}

double squaredDistanceToPiece(const Vec<2>& x, const WallPiece<2>& piece) {
    return squaredDistanceToSegment(x, piece[0], piece[1]);
}

double squaredDistanceToPiece(const Vec<3>& x, const WallPiece<3>& piece) {
    const Vec<3> ab = piece[1] - piece[0], ac = piece[2] - piece[0], ap = x - piece[0];
    const Vec<3> n = cross(ab, ac);
    const double nn = squaredLength(n);
    // The normal of a thinner sliver is noise, but then its edges are near all of it.
    if (nn > 1e-16 * squaredLength(ab) * squaredLength(ac)) {
        const double u = dot(cross(ab, ap), n), v = dot(cross(ap, ac), n);
        if (u >= 0 && v >= 0 && u + v <= nn) {
            const double h = dot(ap, n);
            return h * h / nn;
        }
    }
    return std::min({squaredDistanceToSegment(x, piece[0], piece[1]),
                     squaredDistanceToSegment(x, piece[1], piece[2]),
                     squaredDistanceToSegment(x, piece[2], piece[0])});
}

template <int Dim>
WallTree<Dim>::WallTree(std::vector<WallPiece<Dim>> pieces) : pieces_(std::move(pieces)) {
    struct Builder {
        std::vector<WallPiece<Dim>>& source;
        WallTree& tree;
        struct Item {
            std::uint32_t piece;
            std::array<float, static_cast<std::size_t>(Dim)> center;
        };
        std::vector<Item> items;

        void build(std::uint32_t node, std::uint32_t first, std::uint32_t count) {
            Node& me = tree.nodes_[node];
            if (count <= kLeafPieces) {
                Box<Dim> box;
                for (std::uint32_t k = first; k < first + count; ++k) {
                    const auto b = boxOf<Dim>(source[items[k].piece]);
                    box.add(b.lo);
                    box.add(b.hi);
                }
                for (int i = 0; i < Dim; ++i) {
                    me.lo[static_cast<std::size_t>(i)] = below(box.lo[i] - tree.origin_[i]);
                    me.hi[static_cast<std::size_t>(i)] = above(box.hi[i] - tree.origin_[i]);
                }
                me.first = first;
                me.count = count;
                return;
            }
            std::array<float, static_cast<std::size_t>(Dim)> lo = items[first].center, hi = lo;
            for (std::uint32_t k = first; k < first + count; ++k)
                for (std::size_t i = 0; i < lo.size(); ++i) {
                    lo[i] = std::min(lo[i], items[k].center[i]);
                    hi[i] = std::max(hi[i], items[k].center[i]);
                }
            std::size_t longest = 0;
            for (std::size_t i = 1; i < lo.size(); ++i)
                if (hi[i] - lo[i] > hi[longest] - lo[longest]) longest = i;
            const std::uint32_t half = count / 2;
            const auto begin = items.begin() + static_cast<std::ptrdiff_t>(first);
            std::nth_element(begin, begin + half, begin + count,
                             [longest](const Item& a, const Item& b) {
                                 return a.center[longest] < b.center[longest];
                             });
            const std::uint32_t left = node + 1, right = left + nodeCount(half);
            const auto one = [&] { build(left, first, half); };
            const auto other = [&] { build(right, first + half, count - half); };
            if (count > 8192) {
                tbb::parallel_invoke(one, other);
            } else {
                one();
                other();
            }
            me.first = right;
            me.count = 0;
            for (std::size_t i = 0; i < lo.size(); ++i) {
                me.lo[i] = std::min(tree.nodes_[left].lo[i], tree.nodes_[right].lo[i]);
                me.hi[i] = std::max(tree.nodes_[left].hi[i], tree.nodes_[right].hi[i]);
            }
        }
    };

    const auto n = static_cast<std::uint32_t>(pieces_.size());
    Box<Dim> bounds;
    for (const auto& piece : pieces_)
        for (const auto& p : piece) bounds.add(p);
    origin_ = bounds.center();
    nodes_.resize(nodeCount(n));
    Builder builder{pieces_, *this, {}};
    builder.items.resize(n);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, n, 4096), [&](const auto& block) {
        for (std::uint32_t k = block.begin(); k < block.end(); ++k) {
            const Vec<Dim> c = boxOf<Dim>(pieces_[k]).center() - origin_;
            builder.items[k].piece = k;
            for (int i = 0; i < Dim; ++i)
                builder.items[k].center[static_cast<std::size_t>(i)] = static_cast<float>(c[i]);
        }
    });
    builder.build(0, 0, n);
    std::vector<WallPiece<Dim>> ordered(n);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, n, 4096), [&](const auto& block) {
        for (std::uint32_t k = block.begin(); k < block.end(); ++k)
            ordered[k] = pieces_[builder.items[k].piece];
    });
    pieces_ = std::move(ordered);
}

template <int Dim>
double WallTree<Dim>::squaredDistanceToBox(const Vec<Dim>& x, const Node& node) const {
    double d2 = 0;
    for (int i = 0; i < Dim; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double d = std::max({node.lo[k] - x[i], x[i] - node.hi[k], 0.0});
        d2 += d * d;
    }
    return d2;
}

template <int Dim>
double WallTree<Dim>::squaredDistance(const Vec<Dim>& x, double bound) const {
    struct Open {
        std::uint32_t node;
        double d2;
    };
    std::array<Open, 64> stack;  // the tree halves, so its depth is below 32
    const Vec<Dim> local = x - origin_;
    std::size_t top = 0;
    stack[top++] = {0, squaredDistanceToBox(local, nodes_[0])};
    while (top > 0) {
        const Open open = stack[--top];
        if (open.d2 >= bound) continue;
        std::uint32_t at = open.node;
        bool alive = true;
        while (alive && nodes_[at].count == 0) {
            std::uint32_t near = at + 1, far = nodes_[at].first;
            double dn = squaredDistanceToBox(local, nodes_[near]);
            double df = squaredDistanceToBox(local, nodes_[far]);
            if (df < dn) {
                std::swap(near, far);
                std::swap(dn, df);
            }
            if (df < bound) stack[top++] = {far, df};
            at = near;
            alive = dn < bound;
        }
        if (!alive) continue;
        const Node& leaf = nodes_[at];
        for (std::uint32_t k = leaf.first; k < leaf.first + leaf.count; ++k)
            bound = std::min(bound, squaredDistanceToPiece(x, pieces_[k]));
    }
    return bound;
}

template <int Dim>
std::size_t WallCrossings<Dim>::clampedBin(double x, int i) const {
    const auto k = static_cast<std::size_t>(i);
    const double b = (x - bounds_.lo[across_[k]]) / binSize_[k];
    return static_cast<std::size_t>(std::clamp(b, 0.0, static_cast<double>(bins_[k] - 1)));
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
    // About one bin a piece, bins near square, and entries bounded by coarser bins if need be.
    const double n = static_cast<double>(pieces.size());
    const Vec<Dim> size = bounds_.size();
    const double su = size[across_[0]], sv = Dim == 3 ? size[across_[1]] : 0;
    double nu = n, nv = 1;
    if (Dim == 3) {
        const double aspect = su > 0 && sv > 0 ? su / sv : 1;
        nu = std::clamp(std::sqrt(n * aspect), 1.0, kMostBinsAnAxis);
        nv = std::clamp(n / nu, 1.0, kMostBinsAnAxis);
    }
    const auto blocks = tbb::blocked_range<std::size_t>(0, pieces.size(), 1024);
    for (;;) {
        bins_ = {static_cast<std::size_t>(nu), static_cast<std::size_t>(nv)};
        binSize_ = {su > 0 ? su / static_cast<double>(bins_[0]) : 1.0,
                    sv > 0 ? sv / static_cast<double>(bins_[1]) : 1.0};
        // Rows count like entries and counting ends at the limit: a mesh of nothing but giant
        // triangles must not cost the product of triangles and rows.
        const std::size_t most = 24 * pieces.size() + 1024;
        std::atomic<std::size_t> entries{0};
        tbb::parallel_for(blocks, [&](const auto& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                if (i % 64 == 0 && entries.load(std::memory_order_relaxed) > most) return;
                std::size_t sum = 0;
                forEachRun(pieces[i],
                           [&](std::size_t first, std::size_t last) { sum += last - first + 1; });
                entries.fetch_add(sum, std::memory_order_relaxed);
            }
        });
        if (entries <= most || bins_[0] * bins_[1] == 1) break;
        nu = std::max(1.0, nu / 2);
        nv = std::max(1.0, nv / 2);
    }
    const std::size_t count = bins_[0] * bins_[1];
    std::vector<std::atomic<std::uint32_t>> next(count);
    tbb::parallel_for(blocks, [&](const auto& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i)
            forEachRun(pieces[i], [&](std::size_t first, std::size_t last) {
                for (std::size_t b = first; b <= last; ++b)
                    next[b].fetch_add(1, std::memory_order_relaxed);
            });
    });
    start_.resize(count + 1);
    std::uint32_t sum = 0;
    for (std::size_t b = 0; b < count; ++b) {
        start_[b] = sum;
        sum += next[b].load(std::memory_order_relaxed);
        next[b].store(start_[b], std::memory_order_relaxed);
    }
    start_[count] = sum;
    members_.resize(sum);
    tbb::parallel_for(blocks, [&](const auto& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i)
            forEachRun(pieces[i], [&](std::size_t first, std::size_t last) {
                for (std::size_t b = first; b <= last; ++b)
                    members_[next[b].fetch_add(1, std::memory_order_relaxed)] =
                        static_cast<std::uint32_t>(i);
            });
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
                  tbb::blocked_range<std::size_t>(0, pieces.size(), 4096), std::uint64_t{0},
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

template double squaredDistanceToSegment<2>(const Vec<2>&, const Vec<2>&, const Vec<2>&);
template double squaredDistanceToSegment<3>(const Vec<3>&, const Vec<3>&, const Vec<3>&);
template class WallTree<2>;
template class WallTree<3>;
template class WallCrossings<2>;
template class WallCrossings<3>;
template class WallSides<2>;
template class WallSides<3>;

}  // namespace vdbpack
