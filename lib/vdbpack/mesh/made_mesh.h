// Meshes made of boxes and of other meshes.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/mesh/triangle_mesh.h"

namespace vdbpack {

/// The six sides of a box, two triangles each, that face outwards.
inline TriangleMesh boxMesh(const Box<3>& box) {
    TriangleMesh mesh;
    for (int corner = 0; corner < 8; ++corner) {
        Vec<3> v;
        for (int d = 0; d < 3; ++d) v[d] = (corner >> d & 1) != 0 ? box.hi[d] : box.lo[d];
        mesh.vertices.push_back(v);
    }
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// Adds the triangles of a mesh to another.
inline void append(TriangleMesh& mesh, const TriangleMesh& more) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
    for (auto triangle : more.triangles) {
        for (auto& v : triangle) v += first;
        mesh.triangles.push_back(triangle);
    }
}

}  // namespace vdbpack
