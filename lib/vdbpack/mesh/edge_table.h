// The edges of a triangle mesh, each with the triangles that use it. Private to mesh and repair.
#pragma once

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// True if a triangle names a vertex twice: it has no area and takes no part in the topology.
inline bool isCollapsed(const std::array<std::uint32_t, 3>& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// All edges of a mesh but the edges of collapsed triangles.
///
/// Uses of edges are in rows by the lower vertex, sorted within a row: linear time, 8 bytes per
/// use.
class EdgeTable {
public:
    /// One use of an edge by a triangle.
    struct Use {
        std::uint32_t upper;  ///< the larger vertex index of the edge
        std::uint32_t side;   ///< 3 * triangle + k; the side runs from corner k to corner k + 1
        std::uint32_t triangle() const { return side / 3; }
    };

    explicit EdgeTable(const TriangleMesh& mesh) : mesh_(mesh), rows_(mesh.vertices.size() + 1, 0) {
        const auto& triangles = mesh.triangles;
        for (const auto& t : triangles) {
            if (isCollapsed(t)) continue;
            for (std::size_t k = 0; k < 3; ++k) ++rows_[std::min(t[k], t[(k + 1) % 3]) + 1];
        }
        for (std::size_t v = 1; v < rows_.size(); ++v) rows_[v] += rows_[v - 1];
        uses_.resize(rows_.back());
        std::vector<std::size_t> next(rows_.begin(), rows_.end() - 1);
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const auto& t = triangles[i];
            if (isCollapsed(t)) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [lower, upper] = std::minmax(t[k], t[(k + 1) % 3]);
                uses_[next[lower]++] = {upper, static_cast<std::uint32_t>(3 * i + k)};
            }
        }
        forAll(mesh.vertices.size(), [&](std::size_t v) {
            std::sort(uses_.begin() + static_cast<std::ptrdiff_t>(rows_[v]),
                      uses_.begin() + static_cast<std::ptrdiff_t>(rows_[v + 1]),
                      [](const Use& a, const Use& b) {
                          return a.upper != b.upper ? a.upper < b.upper : a.side < b.side;
                      });
        });
    }

    /// Calls `f(lower, upper, first, last)` for every edge in rising order of its vertices;
    /// [first, last) are its uses, in the order of the triangles.
    template <typename F>
    void forEach(F&& f) const {
        for (std::size_t v = 0; v + 1 < rows_.size(); ++v) {
            const Use* const end = uses_.data() + rows_[v + 1];
            for (const Use* first = uses_.data() + rows_[v]; first != end;) {
                const Use* last = first;
                while (last != end && last->upper == first->upper) ++last;
                f(static_cast<std::uint32_t>(v), first->upper, first, last);
                first = last;
            }
        }
    }

    /// True if the side runs from the lower vertex of its edge to the upper one.
    bool isForward(const Use& use) const {
        return mesh_.triangles[use.triangle()][(use.side + 1) % 3] == use.upper;
    }

    /// How many more of the uses [first, last) of an edge run forward than backward: 0 where the
    /// triangles around it cancel, as at every edge of a closed surface that faces one way.
    int surplus(const Use* first, const Use* last) const {
        int forward = 0;
        for (const Use* use = first; use != last; ++use) forward += isForward(*use) ? 1 : -1;
        return forward;
    }

private:
    const TriangleMesh& mesh_;
    std::vector<std::size_t> rows_;
    std::vector<Use> uses_;
};

/// Groups edges that are connected by their vertices: a number for each edge, from 0 on. Linear in
/// the edges and the vertices of their mesh.
inline std::vector<std::uint32_t> groupEdges(
    const std::vector<std::array<std::uint32_t, 2>>& edges) {
    // The vertices in question get small numbers for the union-find, in their order.
    std::uint32_t end = 0;
    for (const auto& e : edges) end = std::max({end, e[0] + 1, e[1] + 1});
    std::vector<std::uint32_t> number(end, 0);
    for (const auto& e : edges) number[e[0]] = number[e[1]] = 1;
    std::uint32_t vertices = 0;
    for (auto& n : number)
        if (n != 0) n = vertices++;
    DisjointSets sets(vertices);
    for (const auto& e : edges) sets.join(number[e[0]], number[e[1]]);
    std::vector<std::uint32_t> name(vertices, 0);
    std::uint32_t groups = 0;
    for (std::uint32_t i = 0; i < name.size(); ++i)
        if (sets.find(i) == i) name[i] = groups++;
    std::vector<std::uint32_t> result;
    result.reserve(edges.size());
    for (const auto& e : edges) result.push_back(name[sets.find(number[e[0]])]);
    return result;
}

}  // namespace vdbpack
