// The surfaces of labels as meshes.
#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/image/surface_net.h"

#include <tbb/parallel_sort.h>

#include <limits>
#include <set>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// One side of a face.
struct Side {
    std::uint64_t edge;                       // its lower vertex and the axis along which it lies
    std::uint64_t insideVoxel, outsideVoxel;  // of the face
    std::uint32_t face;
    std::uint32_t corner;  // where the side begins
};

/// Joins the corners of faces that go on into one another.
///
/// Where two voxels inside meet at an edge alone, four faces do. Those of each voxel inside go on
/// into one another, so that the surfaces of both touch there and do not cross; but if the faces
/// are joined at both ends of the edge by others, those of each voxel outside do.
/// @param sides  of all faces, those of an edge together, sorted by the voxels inside.
DisjointSets joinedCorners(const SurfaceNet& net, const std::vector<std::uint32_t>& faces,
                           const std::vector<Side>& sides) {
    const auto vertexAt = [&](const Side& side, std::uint32_t end) {
        return net.faces[faces[side.face]].vertices[(side.corner + end) % 4];
    };
    const auto cornerAt = [&](const Side& side, std::uint32_t vertex) {
        return 4 * side.face + (vertexAt(side, 0) == vertex ? side.corner : (side.corner + 1) % 4);
    };
    const auto endOf = [&](std::size_t s) {
        std::size_t end = s + 1;
        while (end < sides.size() && sides[end].edge == sides[s].edge) ++end;
        return end;
    };
    std::set<std::uint64_t> byOutside;  // edges
    for (;;) {
        DisjointSets corners(4 * faces.size());
        const auto join = [&](const Side& a, const Side& b) {
            for (std::uint32_t end = 0; end < 2; ++end) {
                const std::uint32_t vertex = vertexAt(a, end);
                corners.join(cornerAt(a, vertex), cornerAt(b, vertex));
            }
        };
        for (std::size_t s = 0, end = 0; s < sides.size(); s = end) {
            end = endOf(s);
            if (end - s == 4 && byOutside.count(sides[s].edge)) {
                const bool same = sides[s].outsideVoxel == sides[s + 2].outsideVoxel;
                join(sides[s], sides[same ? s + 2 : s + 3]);
                join(sides[s + 1], sides[same ? s + 3 : s + 2]);
            } else {
                for (std::size_t k = s; k + 1 < end; k += 2) join(sides[k], sides[k + 1]);
            }
        }
        const std::size_t before = byOutside.size();
        for (std::size_t s = 0, end = 0; s < sides.size(); s = end) {
            end = endOf(s);
            if (end - s != 4) continue;
            bool joined = true;
            for (std::uint32_t e = 0; e < 2; ++e) {
                const std::uint32_t vertex = vertexAt(sides[s], e);
                joined = joined &&
                         corners.find(cornerAt(sides[s], vertex)) ==
                             corners.find(cornerAt(sides[s + 2], vertex)) &&
                         corners.find(cornerAt(sides[s], vertex)) ==
                             corners.find(cornerAt(sides[s + 3], vertex));
            }
            if (joined) byOutside.insert(sides[s].edge);
        }
        if (byOutside.size() == before) return corners;
    }
}

/// The sides of faces, in the order that `joinedCorners` takes.
std::vector<Side> sidesOf(const SurfaceNet& net, const std::vector<std::uint32_t>& faces,
                          const std::function<bool(std::uint16_t)>& inside) {
    std::vector<Side> sides(4 * faces.size());
    parallelFor(IndexRange(0, faces.size(), 4096), [&](const auto& block) {
        for (std::size_t f = block.begin(); f < block.end(); ++f) {
            const SurfaceNet::Face& face = net.faces[faces[f]];
            auto voxel = net.cells[face.vertices[0]];  // counted from 1
            for (std::size_t d = 0; d < 3; ++d)
                if (d != face.axis) ++voxel[d];
            const auto number = [](const std::array<std::uint16_t, 3>& v) {
                return static_cast<std::uint64_t>(v[0]) | static_cast<std::uint64_t>(v[1]) << 16 |
                       static_cast<std::uint64_t>(v[2]) << 32;
            };
            std::uint64_t in = number(voxel);
            ++voxel[face.axis];
            std::uint64_t out = number(voxel);
            if (!inside(face.below)) std::swap(in, out);
            for (std::uint32_t k = 0; k < 4; ++k) {
                const std::uint32_t a = face.vertices[k], b = face.vertices[(k + 1) % 4];
                std::uint64_t axis = 0;
                while (net.cells[a][axis] == net.cells[b][axis]) ++axis;
                // Vertices are numbered by cells in this order.
                sides[4 * f + k] = {static_cast<std::uint64_t>(std::min(a, b)) * 3 + axis, in, out,
                                    static_cast<std::uint32_t>(f), k};
            }
        }
    });
    tbb::parallel_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.edge, a.insideVoxel, a.face) < std::tie(b.edge, b.insideVoxel, b.face);
    });
    return sides;
}

}  // namespace

TriangleMesh surfaceOf(const SurfaceNet& net, const ImageGrid& grid,
                       const std::function<bool(std::uint16_t)>& inside) {
    std::vector<std::uint32_t> faces;
    for (std::size_t f = 0; f < net.faces.size(); ++f)
        if (inside(net.faces[f].below) != inside(net.faces[f].above))
            faces.push_back(static_cast<std::uint32_t>(f));
    if (faces.size() >= kNoVertex / 4)
        throw ResourceError(
            "the surface of a label has more than 1,000,000,000 faces; give a coarser image");
    std::vector<Side> sides = sidesOf(net, faces, inside);
    DisjointSets corners = joinedCorners(net, faces, sides);
    sides = {};
    TriangleMesh mesh;
    std::vector<std::uint32_t> number(4 * faces.size(), kNoVertex);
    mesh.triangles.resize(2 * faces.size());
    const bool mirrored = grid.signedVoxelVolume() < 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const SurfaceNet::Face& face = net.faces[faces[f]];
        std::array<std::uint32_t, 4> q;
        for (std::uint32_t k = 0; k < 4; ++k) {
            const std::uint32_t root = corners.find(static_cast<std::uint32_t>(4 * f) + k);
            if (number[root] == kNoVertex) {
                number[root] = static_cast<std::uint32_t>(mesh.vertices.size());
                mesh.vertices.push_back(grid.at(net.vertices[face.vertices[k]]));
            }
            q[k] = number[root];
        }
        // The shorter diagonal, the same for both labels.
        const auto& v = mesh.vertices;
        const bool other = squaredLength(v[q[1]] - v[q[3]]) < squaredLength(v[q[0]] - v[q[2]]);
        std::array<std::array<std::uint32_t, 3>, 2> pair{{{q[0], q[1], q[2]}, {q[0], q[2], q[3]}}};
        if (other) pair = {{{q[0], q[1], q[3]}, {q[1], q[2], q[3]}}};
        for (auto& triangle : pair)
            if (inside(face.below) == mirrored) std::swap(triangle[1], triangle[2]);
        mesh.triangles[2 * f] = pair[0];
        mesh.triangles[2 * f + 1] = pair[1];
    }
    return mesh;
}

}  // namespace vdbpack
