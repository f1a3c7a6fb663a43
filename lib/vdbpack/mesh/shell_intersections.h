// Private to mesh: closed shells that pass through each other.
#pragma once

#include "vdbpack/mesh/mesh_shells.h"

namespace vdbpack {

/// Pairs of closed shells of which one lies partly inside the other: an edge of one passes through
/// a triangle of the other. Shells that only touch do not count.
struct ShellIntersections {
    std::size_t pairs = 0;
    double volume = 0;  ///< inside both of a pair, all pairs together, mm³; of points, to some 2 %
    Vec<3> at;          ///< middle of what the pair with the largest such volume shares, mm
};

/// Cost: a tree over the triangles in boxes around other closed shells.
ShellIntersections findIntersections(const TriangleMesh& mesh, const ShellAnalysis& analysis);

}  // namespace vdbpack
