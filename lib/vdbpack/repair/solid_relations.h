// Private to repair: whether closed surfaces intersect, and which lies inside which.
#pragma once

#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/mesh/triangle_tree.h"

#include <cstdint>

namespace vdbpack {

enum class SolidRelation {
    apart,      ///< no common volume; they may touch
    intersect,  ///< a part of each lies inside the other, or they coincide
    inside,     ///< the first lies inside the second
    around      ///< the second lies inside the first
};

/// A watertight surface that faces outward, ready for questions. Immutable.
class Solid {
public:
    explicit Solid(TriangleMesh mesh);

    const TriangleMesh& mesh() const { return mesh_; }
    const Box<3>& bounds() const { return bounds_; }

    /// Surfaces that come closer than 10⁻⁶ of the smaller one's size count as touching. Cost: the
    /// triangles of both whose boxes meet, and five inside tests per thousand of them.
    friend SolidRelation relationOf(const Solid& a, const Solid& b);

private:
    Box<3> boxOf(std::uint32_t triangle) const;
    /// Whether an edge of one surface passes through a triangle of the other.
    static bool pierce(const Solid& small, const Solid& large, double tolerance);

    TriangleMesh mesh_;
    Box<3> bounds_;
    MeshSides sides_;
    TriangleTree tree_;
};

SolidRelation relationOf(const Solid& a, const Solid& b);

}  // namespace vdbpack
