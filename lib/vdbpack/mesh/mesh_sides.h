// Which side of a mesh a point is on, by its triangles alone.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/mesh/triangle_tree.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

/// Inside tests by counting crossings along a line.
///
/// Inside means an odd number of crossings, so nested shells bound cavities, for any orientation.
/// For a closed mesh whose edges all join two triangles the count along one axis is exact, also for
/// lines through edges and vertices. For other meshes lines to both sides along the three axes
/// vote, and a tie is outside. Immutable; shared between threads.
///
/// Cost: a few times the mesh's memory; a query passes the triangles over one small cell, or, where
/// long triangles crowd the cells, a few in a tree.
class MeshSides {
public:
    /// @param clean  every edge joins two triangles. `mesh` is welded (welding.h), and copied where
    ///               lines do not go along z.
    MeshSides(const SharedMesh& mesh, bool clean);
    MeshSides(const TriangleMesh& mesh, bool clean)
        : MeshSides(std::make_shared<const TriangleMesh>(mesh), clean) {}

    bool inside(const Vec<3>& x) const;
    /// How often the surface winds around a point, if as many triangles pass each edge in one
    /// direction as in the other: 1 inside a surface that faces outward, 2 where two such overlap.
    int winding(const Vec<3>& x) const;

private:
    /// Triangles by the cells of a plane that their shadows meet.
    struct Columns {
        SharedMesh shared;  ///< with the axis of the lines as z
        Box<3> bounds;
        int count[2] = {1, 1};
        double perLength[2] = {0, 0};
        std::vector<std::uint32_t> start;
        std::vector<std::uint32_t> triangles;
        TriangleTree tree;  ///< instead of the cells

        explicit Columns(SharedMesh mesh);
        void setCells(double edge);
        double places() const;
        void fillCells();
        /// Calls `visit(cell)` for the cells that the shadow's bounds of a triangle meet.
        template <class Visit>
        void forEachCell(std::size_t triangle, const Visit& visit) const;
        struct Range {
            int i0, i1, j0, j1;
        };
        Range rangeOf(std::size_t triangle) const;
        int index(double x, int axis) const;
        struct Crossings {
            int above = 0, below = 0;
            int turns = 0;  ///< of those above: outward less inward
        };
        Crossings cross(const Vec<3>& x) const;
    };
    static Vec<3> turned(const Vec<3>& v, std::size_t axis);

    std::size_t first_ = 2;  ///< axis of the first columns; those of the next axes follow
    std::vector<Columns> axes_;
};

}  // namespace vdbpack
