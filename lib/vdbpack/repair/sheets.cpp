#include "vdbpack/repair/sheets.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/mesh/edge_sheets.h"
#include "vdbpack/mesh/edge_table.h"

#include <vector>

namespace vdbpack {

namespace {

/// Corners of triangles (corner k of triangle i is 3 i + k) that are connected by paired sides.
struct Corners {
    DisjointSets sets;
    std::size_t parted = 0;  ///< edges with more than two triangles
};

Corners connectCorners(const TriangleMesh& mesh) {
    Corners corners{DisjointSets(3 * mesh.triangles.size())};
    const EdgeTable edges(mesh);
    const auto joinAlong = [&](const EdgeTable::Use& a, const EdgeTable::Use& b) {
        const auto end = [](std::uint32_t side) { return side / 3 * 3 + (side % 3 + 1) % 3; };
        // Consistent sides run in opposite directions: the start of one is the end of the other.
        const bool opposite = edges.isForward(a) != edges.isForward(b);
        corners.sets.join(a.side, opposite ? end(b.side) : b.side);
        corners.sets.join(end(a.side), opposite ? b.side : end(b.side));
    };
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        if (last - first == 2) joinAlong(first[0], first[1]);
        if (last - first <= 2) return;
        ++corners.parted;
        for (const SheetPair& pair :
             pairSheets(mesh, edges, lower, upper, first, last, CommonWalls::apart))
            joinAlong(pair.begin, pair.end);
    });
    return corners;
}

/// Gives every group of connected corners a vertex; the first group at a vertex keeps its index.
void separate(TriangleMesh& mesh, DisjointSets& corners) {
    std::vector<char> taken(mesh.vertices.size(), 0);
    std::vector<std::uint32_t> vertexOf(3 * mesh.triangles.size(), 0);
    std::vector<char> known(3 * mesh.triangles.size(), 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t root = corners.find(static_cast<std::uint32_t>(3 * i + k));
            std::uint32_t& v = mesh.triangles[i][k];
            if (known[root] == 0) {
                known[root] = 1;
                if (taken[v] == 0) {
                    taken[v] = 1;
                    vertexOf[root] = v;
                } else {
                    vertexOf[root] = static_cast<std::uint32_t>(mesh.vertices.size());
                    mesh.vertices.push_back(Vec<3>(mesh.vertices[v]));
                }
            }
            v = vertexOf[root];
        }
}

}  // namespace

std::size_t partSheets(TriangleMesh& mesh) {
    Corners corners = connectCorners(mesh);
    if (corners.parted > 0) separate(mesh, corners.sets);
    return corners.parted;
}

TriangleMesh manifoldOf(const TriangleMesh& mesh) {
    TriangleMesh split = mesh;
    Corners corners = connectCorners(mesh);
    separate(split, corners.sets);
    return split;
}

}  // namespace vdbpack
