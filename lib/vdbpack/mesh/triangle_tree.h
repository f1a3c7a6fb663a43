// Private to mesh, repair and domain: a tree of oriented boxes over triangles, for meshes whose
// triangles are long.
#pragma once

#include "vdbpack/core/vec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace vdbpack {

/// Boxes along the principal axes of the triangles in them, halved over and over.
///
/// Cells and upright boxes serve bones better, but a fan of n long triangles around one corner
/// meets n cells in each row, and every box along the axes that holds one of them holds a share of
/// all. An oriented box fits a sector of the fan, so that a search passes about log n of them.
///
/// Memory: 70 to 140 bytes a triangle, whatever its shape. Immutable; shared between threads.
class TriangleTree {
public:
    using Corners = std::array<Vec<3>, 3>;

    TriangleTree() = default;
    /// @param cornersOf  the corners of a triangle by its number, finite. Cost: n log n, in
    /// parallel.
    TriangleTree(std::size_t triangles, const std::function<Corners(std::size_t)>& cornersOf);

    bool empty() const { return nodes_.empty(); }
    std::size_t memoryBytes() const {
        return nodes_.capacity() * sizeof(Node) + order_.capacity() * sizeof(std::uint32_t);
    }

    /// Calls `visit(triangle)` for all triangles that may be as near to `x` as the root of `best`,
    /// near ones first. `visit` may lower `best`; it returns true to end the search.
    template <class Visit>
    void visitNear(const Vec<3>& x, const double& best, const Visit& visit) const {
        if (empty()) return;
        struct Open {
            std::uint32_t node;
            double square;
        };
        std::array<Open, kDeepest> stack;
        std::size_t top = 0;
        stack[top++] = {0, nodes_[0].squaredDistance(x)};
        while (top > 0) {
            Open open = stack[--top];
            while (open.square <= best && nodes_[open.node].count == 0) {
                Open near{open.node + 1, nodes_[open.node + 1].squaredDistance(x)};
                Open far{nodes_[open.node].first, 0};
                far.square = nodes_[far.node].squaredDistance(x);
                if (far.square < near.square) std::swap(near, far);
                if (far.square <= best) stack[top++] = far;
                open = near;
            }
            if (!(open.square <= best)) continue;
            const Node& leaf = nodes_[open.node];
            for (std::uint32_t k = leaf.first; k < leaf.first + leaf.count; ++k)
                if (visit(order_[k])) return;
        }
    }

    /// Calls `visit(triangle)` for all triangles that the line through `x` along z may meet.
    template <class Visit>
    void visitAlongZ(const Vec<3>& x, const Visit& visit) const {
        if (empty()) return;
        std::array<std::uint32_t, kDeepest> stack;
        std::size_t top = 0;
        stack[top++] = 0;
        while (top > 0) {
            const std::uint32_t at = stack[--top];
            const Node& node = nodes_[at];
            if (!node.meetsLineAlongZ(x)) continue;
            if (node.count == 0) {
                stack[top++] = node.first;
                stack[top++] = at + 1;
                continue;
            }
            for (std::uint32_t k = node.first; k < node.first + node.count; ++k) visit(order_[k]);
        }
    }

private:
    /// Twice the depth of a tree that halves 2^32 triangles.
    static constexpr std::size_t kDeepest = 64;

    struct Node {
        Vec<3> center;
        std::array<Vec<3>, 3> axes;  ///< of length one
        Vec<3> half;                 ///< extent along them to either side, rounded up
        std::uint32_t first = 0;     ///< leaf: in `order_`; else the second child (the first: next)
        std::uint32_t count = 0;     ///< triangles of a leaf; 0: not a leaf

        double squaredDistance(const Vec<3>& x) const {
            const Vec<3> to = x - center;
            double sum = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double beyond = std::max(0.0, std::fabs(dot(axes[k], to)) - half.c[k]);
                sum += beyond * beyond;
            }
            return sum;
        }
        bool meetsLineAlongZ(const Vec<3>& x) const {
            const Vec<3> to{{x[0] - center[0], x[1] - center[1], 0}};
            double from = -1e300, until = 1e300;
            for (std::size_t k = 0; k < 3; ++k) {
                const double along = axes[k][2], at = dot(axes[k], to);
                if (std::fabs(along) < 1e-12) {
                    // Tilted by less than the slack over the length of the box.
                    if (std::fabs(at) > half.c[k]) return false;
                    continue;
                }
                const double one = (-half.c[k] - at) / along, other = (half.c[k] - at) / along;
                from = std::max(from, std::min(one, other));
                until = std::min(until, std::max(one, other));
            }
            return from <= until;
        }
    };
    class Builder;

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

}  // namespace vdbpack
