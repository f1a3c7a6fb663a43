// Private to repair: where triangles cross the edges of a lattice.
#pragma once

#include "vdbpack/field/lattice_edge.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <vector>

namespace vdbpack {

/// Where a triangle crosses an edge of the lattice.
struct Crossing {
    EdgeKey edge;
    float at;      ///< share of the edge from its lower end
    float facing;  ///< cosine between the edge and the triangle's normal, without its sign
    bool operator<(const Crossing& other) const {
        return edge != other.edge ? edge < other.edge : at < other.at;
    }
};

/// All crossings, sorted. @param mesh  in voxels about the origin of the lattice
std::vector<Crossing> latticeCrossings(const TriangleMesh& mesh);

}  // namespace vdbpack
