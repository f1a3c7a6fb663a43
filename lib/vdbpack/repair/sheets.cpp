#include "vdbpack/repair/sheets.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/edge_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbpack {

namespace {

/// Angle between triangles below which they coincide, radians.
constexpr double kSameAngle = 1e-9;

/// A triangle at an edge, by its angle around it.
struct Sheet {
    double angle;
    bool forward;
    EdgeTable::Use use;
};

/// The triangles at an edge by increasing angle. Of triangles that coincide, a forward one comes
/// first: it ends a solid before the other begins the next one.
void sortAround(const TriangleMesh& mesh, const EdgeTable& edges, std::uint32_t lower,
                std::uint32_t upper, const EdgeTable::Use* first, const EdgeTable::Use* last,
                std::vector<Sheet>& sheets) {
    const Vec<3>& from = mesh.vertices[lower];
    const Vec<3> along = normalized(mesh.vertices[upper] - from);
    const Vec<3> aside = std::fabs(along[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
    const Vec<3> u = normalized(cross(along, aside));
    const Vec<3> v = cross(along, u);
    sheets.clear();
    for (const auto* use = first; use != last; ++use) {
        const auto& t = mesh.triangles[use->triangle()];
        const Vec<3> d = mesh.vertices[t[(use->side + 2) % 3]] - from;
        const bool forward = edges.isForward(*use);
        double angle = std::atan2(dot(d, v), dot(d, u));
        if (angle < kSameAngle - kPi) angle += 2 * kPi;
        sheets.push_back({angle - (forward ? kSameAngle : 0), forward, *use});
    }
    std::sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) {
        return a.angle != b.angle ? a.angle < b.angle : a.use.side < b.use.side;
    });
}

/// Calls `join(a, b)` for the pairs of sheets with the inside between them. The normal of a forward
/// triangle points to larger angles: with increasing angle the inside begins at a backward triangle
/// and ends at a forward one.
template <typename F>
void pairSheets(const std::vector<Sheet>& sheets, F&& join) {
    std::vector<std::size_t> open;
    const std::size_t n = sheets.size();
    std::vector<char> done(n, 0);
    for (std::size_t round = 0; round < 2 * n; ++round) {
        const std::size_t i = round % n;
        if (done[i] != 0) continue;
        if (!sheets[i].forward) {
            if (std::find(open.begin(), open.end(), i) == open.end()) open.push_back(i);
        } else if (!open.empty()) {
            join(sheets[open.back()].use, sheets[i].use);
            done[open.back()] = done[i] = 1;
            open.pop_back();
        }
    }
}

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
    std::vector<Sheet> sheets;
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        if (last - first == 2) joinAlong(first[0], first[1]);
        if (last - first <= 2) return;
        ++corners.parted;
        sortAround(mesh, edges, lower, upper, first, last, sheets);
        pairSheets(sheets, joinAlong);
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
