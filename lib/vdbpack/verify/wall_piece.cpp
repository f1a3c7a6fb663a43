#include "vdbpack/core/error.h"
#include "vdbpack/verify/wall_shape.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace vdbpack {

namespace {

void requireIndices(const TriangleMesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const auto v : mesh.triangles[t])
            if (v >= mesh.vertices.size())
                throw InputError(fmt::format(
                    "mesh: triangle {} names vertex {} of {}; the mesh is damaged, export it again",
                    t, v, mesh.vertices.size()));
}

}  // namespace

std::vector<WallPiece<3>> wallPieces(const TriangleMesh& mesh) {
    requireIndices(mesh);
    std::vector<WallPiece<3>> pieces(mesh.triangles.size());
    for (std::size_t t = 0; t < pieces.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) pieces[t][k] = mesh.vertices[mesh.triangles[t][k]];
    return pieces;
}

std::vector<WallPiece<2>> sliceSegments(const TriangleMesh& mesh, double height) {
    requireIndices(mesh);
    std::vector<WallPiece<2>> segments;
    for (const auto& t : mesh.triangles) {
        std::array<Vec<2>, 3> ends;
        std::size_t n = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            Vec<3> a = mesh.vertices[t[k]], b = mesh.vertices[t[(k + 1) % 3]];
            if ((a[2] > height) == (b[2] > height)) continue;
            // From the lower to the upper end: the same point in both triangles of the edge.
            if (a[2] > b[2]) std::swap(a, b);
            const double s = (height - a[2]) / (b[2] - a[2]);
            ends[n++] = {{a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])}};
        }
        if (n == 2) segments.push_back({ends[0], ends[1]});
    }
    return segments;
}

}  // namespace vdbpack
