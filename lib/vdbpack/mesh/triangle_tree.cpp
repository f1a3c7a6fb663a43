#include "vdbpack/mesh/triangle_tree.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/count.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/symmetric.h"

#include <tbb/parallel_invoke.h>

#include <numeric>

namespace vdbpack {

namespace {

constexpr std::uint32_t kLeaf = 4;
/// Subtrees of more triangles are built beside each other.
constexpr std::uint32_t kParallel = 4096;

/// Nodes of a subtree over `n` triangles; its shape depends on `n` alone, so that both halves can
/// be written at the same time.
std::uint32_t nodeCount(std::uint32_t n) {
    return n <= kLeaf ? 1 : 1 + nodeCount(n / 2) + nodeCount(n - n / 2);
}

}  // namespace

class TriangleTree::Builder {
public:
    Builder(TriangleTree& tree, const std::function<Corners(std::size_t)>& cornersOf)
        : tree_(tree), corners_(tree.order_.size()) {
        forAll(corners_.size(), [&](std::size_t i) { corners_[i] = cornersOf(i); });
        const Box<3> bounds = boundsOfAll<3>(corners_.size(), [&](std::size_t i, Box<3>& box) {
            for (const auto& corner : corners_[i]) box.add(corner);
        });
        double largest = 0;
        for (int d = 0; d < 3; ++d)
            largest = std::max({largest, std::fabs(bounds.lo[d]), std::fabs(bounds.hi[d])});
        // More than the rounding of a distance to the boxes.
        slack_ = 1e-11 * largest;
    }

    void build() { subtree(0, 0, static_cast<std::uint32_t>(corners_.size())); }

private:
    const Corners& cornersAt(std::uint32_t k) const { return corners_[tree_.order_[k]]; }

    /// The axes in which the corners spread most and least.
    std::array<Vec<3>, 3> axesOf(std::uint32_t first, std::uint32_t end) const {
        const Vec<3> about = cornersAt(first)[0];
        Vec<3> sum{};
        for (std::uint32_t k = first; k < end; ++k)
            for (const auto& corner : cornersAt(k)) sum += corner - about;
        const Vec<3> mean = about + sum * (1.0 / (3.0 * (end - first)));
        Matrix<3> spread{};
        for (std::uint32_t k = first; k < end; ++k)
            for (const auto& corner : cornersAt(k)) {
                const Vec<3> d = corner - mean;
                for (std::size_t i = 0; i < 3; ++i) spread[i] += d * d.c[i];
            }
        return eigenSystem<3>(spread).vectors;
    }

    /// Sets the box of a node. @return the axis along which the middles of its triangles spread
    /// most.
    std::size_t setBox(Node& node, std::uint32_t first, std::uint32_t end) const {
        node.axes = axesOf(first, end);
        const Vec<3> about = cornersAt(first)[0];
        Box<3> box, middles;
        for (std::uint32_t k = first; k < end; ++k) {
            Vec<3> sum{};
            for (const auto& corner : cornersAt(k)) {
                const Vec<3> d = corner - about;
                const Vec<3> local{
                    {dot(node.axes[0], d), dot(node.axes[1], d), dot(node.axes[2], d)}};
                box.add(local);
                sum += local;
            }
            middles.add(sum);
        }
        const Vec<3> middle = box.center();
        node.center = about;
        for (std::size_t k = 0; k < 3; ++k) node.center += node.axes[k] * middle.c[k];
        const Vec<3> size = box.size(), spread = middles.size();
        for (std::size_t k = 0; k < 3; ++k) node.half.c[k] = 0.5 * size.c[k] + slack_;
        return static_cast<std::size_t>(std::max_element(spread.c.begin(), spread.c.end()) -
                                        spread.c.begin());
    }

    /// Writes the nodes from `at` on, over `count` triangles.
    void subtree(std::uint32_t at, std::uint32_t first, std::uint32_t count) {
        Node& node = tree_.nodes_[at];
        const std::size_t longest = setBox(node, first, first + count);
        if (count <= kLeaf) {
            node.first = first;
            node.count = count;
            return;
        }
        const std::uint32_t half = count / 2;
        const Vec<3> axis = node.axes[longest];
        const auto middle = [&](std::uint32_t triangle) {
            const Corners& c = corners_[triangle];
            return dot(axis, (c[0] - node.center) + (c[1] - node.center) + (c[2] - node.center));
        };
        const auto begin = tree_.order_.begin() + static_cast<std::ptrdiff_t>(first);
        std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
            const double one = middle(a), other = middle(b);
            return one != other ? one < other : a < b;
        });
        const std::uint32_t left = at + 1, right = left + nodeCount(half);
        node.first = right;
        const auto lower = [&] { subtree(left, first, half); };
        const auto upper = [&] { subtree(right, first + half, count - half); };
        if (count > kParallel) {
            tbb::parallel_invoke(lower, upper);
        } else {
            lower();
            upper();
        }
    }

    TriangleTree& tree_;
    std::vector<Corners> corners_;
    double slack_ = 0;
};

TriangleTree::TriangleTree(std::size_t triangles,
                           const std::function<Corners(std::size_t)>& cornersOf) {
    if (triangles == 0) return;
    const std::uint32_t n = indexable(triangles, "triangles", "use a mesh of fewer triangles");
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), std::uint32_t{0});
    nodes_.resize(nodeCount(n));
    Builder(*this, cornersOf).build();
}

}  // namespace vdbpack
