#include "vdbpack/verify/wall_tree.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/symmetric.h"
#include "vdbpack/verify/piece_distance.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace vdbpack {

using namespace pieces;

namespace {

constexpr std::uint32_t kLeafPieces = 4;
/// Most pieces of a node with a disc: more are hardly flat.
constexpr std::uint32_t kDiscPieces = 64;
/// Distances to discs are off by less, of that to the center.
constexpr double kDiscRounding = 1e-6;
/// Square of a piece's extent divided by its area, above which it counts as long; that of an
/// equilateral triangle is below 5.
constexpr double kLong = 64;

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

/// Normal of a piece as long as it has area (2D: as it is long).
Vec<2> normalOf(const WallPiece<2>& p) {
    const Vec<2> along = p[1] - p[0];
    return {{-along[1], along[0]}};
}
Vec<3> normalOf(const WallPiece<3>& p) {
    return cross(p[1] - p[0], p[2] - p[0]);
}

}  // namespace

double squaredDistanceToPiece(const Vec<2>& x, const WallPiece<2>& piece) {
    return squaredDistanceTo<double>(piece, x.c, std::numeric_limits<double>::infinity());
}

double squaredDistanceToPiece(const Vec<3>& x, const WallPiece<3>& piece) {
    return squaredDistanceTo<double>(piece, x.c, std::numeric_limits<double>::infinity());
}

/// Halves the pieces at the median of the longest axis, over and over, and writes the nodes.
template <int Dim>
class WallTree<Dim>::Builder {
public:
    Builder(WallTree& tree, double slack)
        : tree_(tree), items_(tree.pieces_.size()), slack_(slack) {
        forAll(items_.size(), [&](std::size_t k) {
            const Vec<Dim> c = boxOf<Dim>(tree_.pieces_[k]).center() - tree_.origin_;
            items_[k].piece = static_cast<std::uint32_t>(k);
            for (std::size_t i = 0; i < c.c.size(); ++i)
                items_[k].center[i] = static_cast<float>(c.c[i]);
        });
    }

    void build() { subtree(0, 0, static_cast<std::uint32_t>(items_.size())); }

    /// Brings the pieces into the order of the items, in place: cycle by cycle.
    void orderPieces() {
        auto& pieces = tree_.pieces_;
        for (std::uint32_t first = 0; first < items_.size(); ++first) {
            const WallPiece<Dim> start = pieces[first];
            std::uint32_t k = first;
            for (;;) {
                const std::uint32_t from = items_[k].piece;
                items_[k].piece = k;
                if (from == first || from == k) break;
                pieces[k] = pieces[from];
                k = from;
            }
            pieces[k] = start;
        }
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

    /// The disc across the mean normal of some pieces.
    Disc discOf(std::uint32_t first, std::uint32_t count) const {
        Disc disc{};
        Vec<Dim> normal{};
        Box<Dim> box;
        for (std::uint32_t k = first; k < first + count; ++k) {
            const WallPiece<Dim>& piece = tree_.pieces_[items_[k].piece];
            normal += normalOf(piece);
            for (const Vec<Dim>& p : piece) box.add(p);
        }
        const double size = length(normal);
        if (!(size > 0) || !std::isfinite(size)) return disc;
        Vec<Dim> center = box.center() - tree_.origin_;
        for (std::size_t i = 0; i < disc.normal.size(); ++i) {
            disc.normal[i] = static_cast<float>(normal.c[i] / size);
            disc.center[i] = static_cast<float>(center.c[i]);
            normal.c[i] = double{disc.normal[i]};
            center.c[i] = double{disc.center[i]};
        }
        double half = 0, square = 0;
        for (std::uint32_t k = first; k < first + count; ++k)
            for (const Vec<Dim>& p : tree_.pieces_[items_[k].piece]) {
                const Vec<Dim> to = p - tree_.origin_ - center;
                const double height = dot(to, normal);
                half = std::max(half, std::abs(height));
                square = std::max(square, squaredLength(to) - height * height);
            }
        const double slack = slack_ + kDiscRounding * std::sqrt(square + half * half);
        disc.half = above(half + slack);
        disc.radius = above(std::sqrt(square) + slack);
        return disc;
    }

    /// The box along the principal axes of some pieces.
    Frame frameOf(std::uint32_t first, std::uint32_t count) const {
        Vec<Dim> mean{};
        const auto forEachCorner = [&](const auto& visit) {
            for (std::uint32_t k = first; k < first + count; ++k)
                for (const auto& p : tree_.pieces_[items_[k].piece]) visit(p - tree_.origin_);
        };
        forEachCorner([&](const Vec<Dim>& p) { mean += p; });
        mean = mean * (1.0 / (Dim * static_cast<double>(count)));
        Matrix<Dim> spread{};
        forEachCorner([&](const Vec<Dim>& p) {
            for (std::size_t i = 0; i < spread.size(); ++i)
                spread[i] += (p - mean) * (p - mean).c[i];
        });
        Frame frame{eigenSystem<Dim>(spread).vectors, {}, {}};
        Box<Dim> box;
        forEachCorner([&](const Vec<Dim>& p) {
            Vec<Dim> local;
            for (std::size_t i = 0; i < spread.size(); ++i)
                local.c[i] = dot(frame.axes[i], p - mean);
            box.add(local);
        });
        frame.center = tree_.origin_ + mean;
        for (std::size_t i = 0; i < spread.size(); ++i) {
            frame.center += frame.axes[i] * box.center().c[i];
            // Rounded up by more than the rounding of a distance.
            frame.half.c[i] = 0.5 * box.size().c[i] + slack_;
        }
        return frame;
    }

    /// Writes the nodes from `at` on, over `count` items.
    void subtree(std::uint32_t at, std::uint32_t first, std::uint32_t count) {
        Node& node = tree_.nodes_[at];
        if (!tree_.frames_.empty()) tree_.frames_[at] = frameOf(first, count);
        if (!tree_.discs_.empty() && count <= kDiscPieces) tree_.discs_[at] = discOf(first, count);
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
    double slack_;  ///< mm
};

namespace {

/// Whether triangles are so long, on average, that upright boxes over them overlap.
bool areLong(const std::vector<WallPiece<3>>& pieces) {
    double squares = 0, areas = 0;
    for (const auto& piece : pieces) {
        squares += squaredLength(boxOf<3>(piece).size());
        areas += 0.5 * length(cross(piece[1] - piece[0], piece[2] - piece[0]));
    }
    return squares > kLong * areas;
}

bool areLong(const std::vector<WallPiece<2>>&) {
    return false;
}

}  // namespace

template <int Dim>
WallTree<Dim>::WallTree(std::vector<WallPiece<Dim>> pieces) : pieces_(std::move(pieces)) {
    Box<Dim> bounds;
    for (const auto& piece : pieces_)
        for (const auto& p : piece) bounds.add(p);
    origin_ = bounds.center();
    nodes_.resize(nodeCount(static_cast<std::uint32_t>(pieces_.size())));
    if (areLong(pieces_))
        frames_.resize(nodes_.size());
    else
        discs_.resize(nodes_.size());
    double largest = 0;
    for (int i = 0; i < Dim; ++i)
        largest = std::max({largest, std::abs(bounds.lo[i]), std::abs(bounds.hi[i])});
    Builder builder(*this, 1e-11 * largest);
    builder.build();
    builder.orderPieces();
}

/// One search for four points.
template <int Dim>
class WallTree<Dim>::Search {
public:
    Search(const WallTree& tree, const Points& points, const Squares& bounds, Pieces& nearest)
        : tree_(tree), nearest_(nearest) {
        for (std::size_t i = 0; i < x_.size(); ++i) {
            for (std::size_t k = 0; k < kTogether; ++k) x_[i][k] = points[k].c[i];
            local_[i] = x_[i] - tree.origin_.c[i];
        }
        std::memcpy(&bound_, &bounds, sizeof bound_);
        const Pieces first = nearest;
        for (std::size_t k = 0; k < kTogether; ++k)
            if (first[k] != kNone && (k == 0 || first[k] != first[k - 1])) lookAt(first[k]);
    }

    Squares run() {
        struct Open {
            std::uint32_t node;
            Four square;
        };
        const auto& nodes = tree_.nodes_;
        std::array<Open, 64> stack;  // the tree halves, so its depth is below 32
        stack[0] = {0, toBox(0)};
        std::size_t top = 1;
        while (top > 0) {
            const Open open = stack[--top];
            std::uint32_t at = open.node;
            bool alive = isNear(at, open.square);
            while (alive && nodes[at].count == 0) {
                std::uint32_t near = at + 1, far = nodes[at].first;
                Four toNear = toBox(near), toFar = toBox(far);
                const Four less = toFar - toNear;
                if (less[0] + less[1] + less[2] + less[3] < 0) {
                    std::swap(near, far);
                    std::swap(toNear, toFar);
                }
                if (any(toFar < bound_)) stack[top++] = {far, toFar};
                at = near;
                alive = isNear(at, toNear);
            }
            for (std::uint32_t k = 0; alive && k < nodes[at].count; ++k)
                lookAt(nodes[at].first + k);
        }
        Squares squares;
        std::memcpy(&squares, &bound_, sizeof squares);
        return squares;
    }

private:
    void lookAt(std::uint32_t piece) {
        const Four square = squaredDistanceTo<Four>(tree_.pieces_[piece], x_, bound_);
        const auto less = square < bound_;
        if (!any(less)) return;
        bound_ = less ? square : bound_;
        for (std::size_t k = 0; k < kTogether; ++k)
            if (less[k] != 0) nearest_[k] = piece;
    }

    /// Squared distances to the box of a node.
    Four toBox(std::uint32_t at) const {
        Four sum{};
        if (!tree_.frames_.empty()) {
            const Frame& frame = tree_.frames_[at];
            const auto to = relative<Four, Dim>(x_, frame.center);
            for (std::size_t i = 0; i < to.size(); ++i) {
                const Four p = product<Four, Dim>(to, frame.axes[i]);
                const Four d = larger(larger(p, -p) - frame.half.c[i], Four{});
                sum += d * d;
            }
            return sum;
        }
        const Node& node = tree_.nodes_[at];
        for (std::size_t i = 0; i < local_.size(); ++i) {
            const Four d = larger(
                larger(double{node.lo[i]} - local_[i], local_[i] - double{node.hi[i]}), Four{});
            sum += d * d;
        }
        return sum;
    }

    /// Whether a piece of a node may be nearer than the bounds. @param box  of `toBox`
    bool isNear(std::uint32_t at, const Four& box) const {
        if (!any(box < bound_)) return false;
        if (tree_.discs_.empty() || tree_.discs_[at].half < 0) return true;
        const Disc& disc = tree_.discs_[at];
        Four height{}, square{};
        for (std::size_t i = 0; i < local_.size(); ++i) {
            const Four to = local_[i] - double{disc.center[i]};
            height += to * double{disc.normal[i]};
            square += to * to;
        }
        const Four zero{};
        const Four beside =
            larger(squareRoot(larger(square - height * height, zero)) - double{disc.radius}, zero);
        const Four beyond = larger(larger(height, -height) - double{disc.half}, zero);
        return any((beside * beside + beyond * beyond) * (1 - kDiscRounding) < bound_);
    }

    const WallTree& tree_;
    Pieces& nearest_;
    Coordinates<Four, Dim> x_, local_;  ///< local: from the tree's origin
    Four bound_;
};

template <int Dim>
typename WallTree<Dim>::Squares WallTree<Dim>::squaredDistances(const Points& points,
                                                                const Squares& bounds,
                                                                Pieces& nearest) const {
    return Search(*this, points, bounds, nearest).run();
}

template <int Dim>
double WallTree<Dim>::squaredDistance(const Vec<Dim>& x, double bound) const {
    Pieces nearest = noPieces();
    return squaredDistances({x, x, x, x}, {bound, bound, bound, bound}, nearest)[0];
}

template class WallTree<2>;
template class WallTree<3>;

}  // namespace vdbpack
