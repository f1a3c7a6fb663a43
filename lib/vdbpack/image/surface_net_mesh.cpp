// The surfaces of labels as meshes.
#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/image/surface_net.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
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

/// Rounds a point to what files in single precision can hold, where that is far below a voxel:
/// then such a file has the very surface.
class Rounding {
public:
    explicit Rounding(const ImageGrid& grid) {
        double farthest = 0, least = std::numeric_limits<double>::infinity();
        for (int d = 0; d < 3; ++d) {
            Vec<3> step;
            step[d] = 1;
            least = std::min(least, length(grid.at(step) - grid.origin));
            farthest = std::max(
                {farthest, std::fabs(grid.bounds().lo[d]), std::fabs(grid.bounds().hi[d])});
        }
        rounds_ = farthest * 0x1p-23 < kFine * least;
    }
    Vec<3> operator()(Vec<3> x) const {
        if (rounds_)
            for (double& c : x.c) c = static_cast<double>(static_cast<float>(c));
        return x;
    }

private:
    static constexpr double kFine = 1e-3;
    bool rounds_ = false;
};

/// Adds a vertex for the corners of faces that go on into one another. Several that a cell has are
/// moved apart, each by a share of the way to the middle of its faces, so that they stay several in
/// files that list points alone; not where another label lies, with which they are shared.
/// @return the vertex of each corner.
std::vector<std::uint32_t> addVertices(const SurfaceNet& net, const ImageGrid& grid,
                                       const std::vector<std::uint32_t>& faces,
                                       const std::function<bool(std::uint16_t)>& inside,
                                       DisjointSets& corners, TriangleMesh& mesh) {
    constexpr double kApart = 0.01;
    std::vector<std::uint32_t> sources;  // vertices of the net
    std::vector<std::uint8_t> added(net.vertices.size());
    std::vector<std::uint32_t> number(4 * faces.size(), kNoVertex);
    const auto sourceOf = [&](std::uint32_t c) { return net.faces[faces[c / 4]].vertices[c % 4]; };
    for (std::uint32_t c = 0; c < number.size(); ++c) {
        const std::uint32_t root = corners.find(c);
        if (number[root] == kNoVertex) {
            number[root] = static_cast<std::uint32_t>(sources.size());
            sources.push_back(sourceOf(c));
            if (added[sources.back()] < 2) ++added[sources.back()];
        }
        number[c] = number[root];
    }
    struct Surroundings {
        int faces = 0;
        Vec<3> sum{};           // of the middles of the faces
        bool isShared = false;  // with another label
    };
    std::map<std::uint32_t, Surroundings> several;
    for (std::uint32_t c = 0; c < number.size(); ++c) {
        if (added[sourceOf(c)] < 2) continue;
        const SurfaceNet::Face& face = net.faces[faces[c / 4]];
        Surroundings& around = several[number[c]];
        ++around.faces;
        for (const std::uint32_t v : face.vertices) around.sum += net.vertices[v] * 0.25;
        for (const std::uint16_t label : {face.below, face.above})
            around.isShared = around.isShared || (!inside(label) && !SurfaceNet::isEmpty(label));
    }
    const Rounding rounded(grid);
    mesh.vertices.resize(sources.size());
    for (std::uint32_t v = 0; v < sources.size(); ++v) mesh.vertices[v] = net.vertices[sources[v]];
    for (const auto& [v, around] : several)
        if (!around.isShared)
            mesh.vertices[v] += (around.sum * (1.0 / around.faces) - mesh.vertices[v]) * kApart;
    forAll(mesh.vertices.size(),
           [&](std::size_t v) { mesh.vertices[v] = rounded(grid.at(mesh.vertices[v])); });
    return number;
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
    const std::vector<std::uint32_t> number = addVertices(net, grid, faces, inside, corners, mesh);
    mesh.triangles.resize(2 * faces.size());
    const bool mirrored = grid.signedVoxelVolume() < 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const SurfaceNet::Face& face = net.faces[faces[f]];
        std::array<std::uint32_t, 4> q;
        for (std::uint32_t k = 0; k < 4; ++k) q[k] = number[4 * f + k];
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
