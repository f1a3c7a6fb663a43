#include "vdbpack/verify/wall_tree.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::uint32_t kLeafPieces = 4;

float below(double v) {
    return std::nextafter(static_cast<float>(v), -std::numeric_limits<float>::infinity());
}
float above(double v) {
    return std::nextafter(static_cast<float>(v), std::numeric_limits<float>::infinity());
}

/// Nodes of a subtree over `n` pieces; its shape depends on `n` alone, so that both halves can be
/// written at the same time.
std::uint32_t nodeCount(std::uint32_t n) {
    return n <= kLeafPieces ? 1 : 1 + nodeCount(n / 2) + nodeCount(n - n / 2);
}

/// Squared distance from `x` to the segment ab, mm².
template <int Dim>
double squaredDistanceToSegment(const Vec<Dim>& x, const Vec<Dim>& a, const Vec<Dim>& b) {
    const Vec<Dim> e = b - a, d = x - a;
    const double ee = dot(e, e), de = dot(d, e);
    if (!(de > 0) || !(ee > 0)) return squaredLength(d);
    if (de >= ee) return squaredLength(x - b);
    return squaredLength(d - e * (de / ee));
}

}  // namespace

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

/// Halves the pieces at the median of the longest axis, over and over, and writes the nodes.
template <int Dim>
class WallTree<Dim>::Builder {
public:
    explicit Builder(WallTree& tree) : tree_(tree), items_(tree.pieces_.size()) {
        forAll(items_.size(), [&](std::size_t k) {
            const Vec<Dim> c = boxOf<Dim>(tree_.pieces_[k]).center() - tree_.origin_;
            items_[k].piece = static_cast<std::uint32_t>(k);
            for (std::size_t i = 0; i < c.c.size(); ++i)
                items_[k].center[i] = static_cast<float>(c.c[i]);
        });
    }

    void build() { subtree(0, 0, static_cast<std::uint32_t>(items_.size())); }

    std::vector<WallPiece<Dim>> orderedPieces() const {
        std::vector<WallPiece<Dim>> ordered(items_.size());
        forAll(items_.size(), [&](std::size_t k) { ordered[k] = tree_.pieces_[items_[k].piece]; });
        return ordered;
    }

private:
    using Floats = std::array<float, static_cast<std::size_t>(Dim)>;
    struct Item {
        std::uint32_t piece;
        Floats center;  ///< from the tree's origin
    };

    void leaf(Node& node, std::uint32_t first, std::uint32_t count) const {
        Box<Dim> box;
        for (std::uint32_t k = first; k < first + count; ++k)
            for (const auto& p : tree_.pieces_[items_[k].piece]) box.add(p);
        for (int i = 0; i < Dim; ++i) {
            node.lo[static_cast<std::size_t>(i)] = below(box.lo[i] - tree_.origin_[i]);
            node.hi[static_cast<std::size_t>(i)] = above(box.hi[i] - tree_.origin_[i]);
        }
        node.first = first;
        node.count = count;
    }

    std::size_t longestAxis(std::uint32_t first, std::uint32_t count) const {
        Floats lo = items_[first].center, hi = lo;
        for (std::uint32_t k = first; k < first + count; ++k)
            for (std::size_t i = 0; i < lo.size(); ++i) {
                lo[i] = std::min(lo[i], items_[k].center[i]);
                hi[i] = std::max(hi[i], items_[k].center[i]);
            }
        std::size_t longest = 0;
        for (std::size_t i = 1; i < lo.size(); ++i)
            if (hi[i] - lo[i] > hi[longest] - lo[longest]) longest = i;
        return longest;
    }

    /// Writes the nodes from `at` on, over `count` items.
    void subtree(std::uint32_t at, std::uint32_t first, std::uint32_t count) {
        Node& node = tree_.nodes_[at];
        if (count <= kLeafPieces) return leaf(node, first, count);
        const std::size_t axis = longestAxis(first, count);
        const std::uint32_t half = count / 2;
        const auto begin = items_.begin() + static_cast<std::ptrdiff_t>(first);
        std::nth_element(begin, begin + half, begin + count, [axis](const Item& a, const Item& b) {
            return a.center[axis] < b.center[axis];
        });
        const std::uint32_t left = at + 1, right = left + nodeCount(half);
        const auto one = [&] { subtree(left, first, half); };
        const auto other = [&] { subtree(right, first + half, count - half); };
        if (count > 8192) {
            tbb::parallel_invoke(one, other);
        } else {
            one();
            other();
        }
        node.first = right;
        node.count = 0;
        for (std::size_t i = 0; i < node.lo.size(); ++i) {
            node.lo[i] = std::min(tree_.nodes_[left].lo[i], tree_.nodes_[right].lo[i]);
            node.hi[i] = std::max(tree_.nodes_[left].hi[i], tree_.nodes_[right].hi[i]);
        }
    }

    WallTree& tree_;
    std::vector<Item> items_;
};

template <int Dim>
WallTree<Dim>::WallTree(std::vector<WallPiece<Dim>> pieces) : pieces_(std::move(pieces)) {
    Box<Dim> bounds;
    for (const auto& piece : pieces_)
        for (const auto& p : piece) bounds.add(p);
    origin_ = bounds.center();
    nodes_.resize(nodeCount(static_cast<std::uint32_t>(pieces_.size())));
    Builder builder(*this);
    builder.build();
    pieces_ = builder.orderedPieces();
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

template class WallTree<2>;
template class WallTree<3>;

}  // namespace vdbpack
