#include "surfacing.h"

#include "vdbpack/core/error.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kHalfWidth = 3;      // voxels, as OpenVDB's own level sets
constexpr int kRelaxations = 5;       // more of them have little effect
constexpr double kGridUnit = 1024.0;  // vertices are rounded to 1 / this, mm

using Triangle = std::array<std::uint32_t, 3>;

// The sculpture sampled in the leaves around its surface.
openvdb::FloatGrid::Ptr levelSetOf(const Sculpture& sculpture, double voxelSize) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    constexpr int kDim = Leaf::DIM;
    const double band = kHalfWidth * voxelSize;
    const Box<3> box = sculpture.bounds().grown(2 * band);
    std::vector<openvdb::Coord> origins;
    Vec<3> lo, hi;
    for (int i = 0; i < 3; ++i) {
        lo[i] = std::floor(box.lo[i] / (voxelSize * kDim));
        hi[i] = std::floor(box.hi[i] / (voxelSize * kDim));
    }
    for (int x = int(lo[0]); x <= int(hi[0]); ++x)
        for (int y = int(lo[1]); y <= int(hi[1]); ++y)
            for (int z = int(lo[2]); z <= int(hi[2]); ++z)
                origins.emplace_back(x * kDim, y * kDim, z * kDim);

    // A leaf farther from the surface than its half diagonal does not contain any of it. The factor
    // allows for values that are distances to first order only.
    const double reach = 2.0 * (0.5 * std::sqrt(3.0) * kDim * voxelSize + band);
    std::vector<std::unique_ptr<Leaf>> leaves(origins.size());
    tbb::parallel_for(std::size_t(0), origins.size(), [&](std::size_t i) {
        const auto at = [&](const openvdb::Coord& c, double offset) {
            return Vec<3>{{(c.x() + offset) * voxelSize, (c.y() + offset) * voxelSize,
                           (c.z() + offset) * voxelSize}};
        };
        if (std::abs(sculpture.distance(at(origins[i], 0.5 * (kDim - 1)))) > reach) return;
        auto leaf = std::make_unique<Leaf>(origins[i], float(band));
        for (openvdb::Index n = 0; n < Leaf::SIZE; ++n) {
            const double d = sculpture.distance(at(leaf->offsetToGlobalCoord(n), 0.0));
            if (std::abs(d) < band)
                leaf->setValueOn(n, float(d));
            else
                leaf->setValueOff(n, float(d < 0 ? -band : band));
        }
        if (leaf->onVoxelCount() > 0) leaves[i] = std::move(leaf);
    });

    auto grid = openvdb::FloatGrid::create(float(band));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    for (auto& leaf : leaves)
        if (leaf) grid->tree().addLeaf(leaf.release());
    openvdb::tools::signedFloodFill(grid->tree());
    return grid;
}

Vec<3> crossOf(const TriangleMesh& m, const Triangle& t) {
    const Vec<3>& a = m.vertices[t[0]];
    return cross(m.vertices[t[1]] - a, m.vertices[t[2]] - a);
}

double signedVolume(const TriangleMesh& m) {
    double v = 0;
    for (const Triangle& t : m.triangles)
        v += dot(m.vertices[t[0]], cross(m.vertices[t[1]], m.vertices[t[2]])) / 6;
    return v;
}

// The squared sine of the smallest angle: small for flat triangles.
double squaredLeastSine(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
    const double ab = squaredLength(b - a), bc = squaredLength(c - b), ca = squaredLength(a - c);
    // sin of the angle at a = |cross| / (|ab| |ac|); the least belongs to the two longest edges.
    const double longest = std::max({ab * bc, bc * ca, ca * ab});
    return longest > 0 ? squaredLength(cross(b - a, c - a)) / longest : 0.0;
}

TriangleMesh quadsOf(const openvdb::FloatGrid& grid) {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(grid, points, triangles, quads, 0.0, 0.0);
    TriangleMesh mesh;
    for (const auto& p : points) mesh.vertices.push_back({{p.x(), p.y(), p.z()}});
    for (const auto& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
    for (const auto& q : quads) {
        const auto v = [&](int i) -> const Vec<3>& { return mesh.vertices[q[i]]; };
        // The shorter diagonal leaves the better triangles.
        if (squaredLength(v(0) - v(2)) <= squaredLength(v(1) - v(3))) {
            mesh.triangles.push_back({q[0], q[1], q[2]});
            mesh.triangles.push_back({q[0], q[2], q[3]});
        } else {
            mesh.triangles.push_back({q[1], q[2], q[3]});
            mesh.triangles.push_back({q[1], q[3], q[0]});
        }
    }
    if (signedVolume(mesh) < 0)
        for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

// Newton steps onto the sculpture's surface, none longer than half a voxel.
Vec<3> onto(const Sculpture& sculpture, Vec<3> p, double voxelSize, int steps) {
    for (int i = 0; i < steps; ++i) {
        const Vec<3> g = sculpture.gradient(p);
        const double gg = squaredLength(g);
        if (gg < 0.01) return p;  // a ridge of the field: no direction to trust
        Vec<3> step = g * (-sculpture.distance(p) / gg);
        const double l = length(step);
        if (l > 0.5 * voxelSize) step *= 0.5 * voxelSize / l;
        p += step;
    }
    return p;
}

// Moves vertices to the middle of their neighbors along the surface, for even triangles.
void relax(TriangleMesh& mesh, const Sculpture& sculpture, double voxelSize) {
    std::vector<Vec<3>> moved(mesh.vertices.size());
    for (int round = 0; round < kRelaxations; ++round) {
        const bool last = round + 1 == kRelaxations;
        std::vector<Vec<3>> sum(mesh.vertices.size()), normal(mesh.vertices.size());
        std::vector<double> weight(mesh.vertices.size());
        for (const Triangle& t : mesh.triangles) {
            const Vec<3> n = crossOf(mesh, t);
            const Vec<3> middle =
                (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) * (1.0 / 3);
            const double area = length(n);
            for (const std::uint32_t v : t) {
                sum[v] += middle * area;
                normal[v] += n;
                weight[v] += area;
            }
        }
        tbb::parallel_for(std::size_t(0), moved.size(), [&](std::size_t v) {
            const Vec<3>& p = mesh.vertices[v];
            moved[v] = p;
            if (weight[v] <= 0) return;
            const Vec<3> n = normalized(normal[v]);
            Vec<3> shift = sum[v] * (1 / weight[v]) - p;
            shift -= n * dot(shift, n);
            moved[v] = onto(sculpture, p + 0.6 * shift, voxelSize, last ? 3 : 1);
        });
        mesh.vertices.swap(moved);
    }
}

// Turns the diagonal of two triangles where that makes the worse of them better, until none
// is left: relaxing moved the corners after the diagonals were chosen.
void flipEdges(TriangleMesh& mesh) {
    for (int round = 0; round < 4; ++round) {
        struct Side {
            std::uint32_t a, b, triangle, opposite;
        };
        std::vector<Side> sides;
        std::vector<std::uint32_t> valence(mesh.vertices.size());
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const Triangle& tri = mesh.triangles[t];
                const auto at = [&](int i) { return tri[static_cast<std::size_t>(i % 3)]; };
                ++valence[at(k)];
                sides.push_back(
                    {std::min(at(k), at(k + 1)), std::max(at(k), at(k + 1)), t, at(k + 2)});
            }
        std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
            return std::tie(x.a, x.b, x.triangle) < std::tie(y.a, y.b, y.triangle);
        });
        std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
        for (std::size_t i = 0; i < sides.size(); ++i)
            if (i == 0 || sides[i].a != sides[i - 1].a || sides[i].b != sides[i - 1].b)
                edges.emplace_back(sides[i].a, sides[i].b);
        std::vector<char> touched(mesh.triangles.size());
        std::size_t flips = 0;
        for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
            const Side &s = sides[i], &o = sides[i + 1];
            if (s.a != o.a || s.b != o.b || touched[s.triangle] || touched[o.triangle]) continue;
            if (valence[s.a] <= 4 || valence[s.b] <= 4) continue;
            const Vec<3>&a = mesh.vertices[s.a], &b = mesh.vertices[s.b],
                  &c = mesh.vertices[s.opposite], &d = mesh.vertices[o.opposite];
            const double before = std::min(squaredLeastSine(a, b, c), squaredLeastSine(a, b, d));
            const double after = std::min(squaredLeastSine(c, d, a), squaredLeastSine(c, d, b));
            if (after <= 1.05 * before) continue;
            // Only where the two are nearly in one plane, so that the surface keeps its shape.
            Triangle s1 = mesh.triangles[s.triangle];
            Triangle o1 = mesh.triangles[o.triangle];
            const Vec<3> n1 = normalized(crossOf(mesh, s1)), n2 = normalized(crossOf(mesh, o1));
            if (dot(n1, n2) < 0.95) continue;
            const auto pair = std::minmax(s.opposite, o.opposite);
            if (std::binary_search(edges.begin(), edges.end(),
                                   std::pair<std::uint32_t, std::uint32_t>(pair)))
                continue;
            for (std::uint32_t& v : s1)
                if (v == s.b) v = o.opposite;
            for (std::uint32_t& v : o1)
                if (v == s.a) v = s.opposite;
            if (dot(crossOf(mesh, s1), n1) <= 0 || dot(crossOf(mesh, o1), n1) <= 0) continue;
            mesh.triangles[s.triangle] = s1;
            mesh.triangles[o.triangle] = o1;
            touched[s.triangle] = touched[o.triangle] = 1;
            --valence[s.a];
            --valence[s.b];
            ++flips;
        }
        if (flips == 0) break;
    }
}

// Rounds the vertices and sorts vertices and triangles.
TriangleMesh canonical(const TriangleMesh& mesh) {
    std::vector<std::pair<Vec<3>, std::uint32_t>> order;
    for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
        Vec<3> p = mesh.vertices[i];
        // Sorted by z, so that neighbors in space are close in the file.
        for (int k = 0; k < 3; ++k) p[k] = std::round(p[k] * kGridUnit) / kGridUnit;
        order.emplace_back(p, i);
    }
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
        return std::make_tuple(a.first[2], a.first[1], a.first[0]) <
               std::make_tuple(b.first[2], b.first[1], b.first[0]);
    });
    TriangleMesh sorted;
    std::vector<std::uint32_t> newIndex(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        sorted.vertices.push_back(order[i].first);
        newIndex[order[i].second] = i;
    }
    for (Triangle t : mesh.triangles) {
        for (std::uint32_t& v : t) v = newIndex[v];
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        sorted.triangles.push_back(t);
    }
    std::sort(sorted.triangles.begin(), sorted.triangles.end());
    return sorted;
}

std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

template <typename T>
void append(std::string& bytes, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
}

}  // namespace

TriangleMesh surfaceOf(const Sculpture& sculpture, double voxelSize) {
    if (!(voxelSize > 0)) throw ParameterError("surfaceOf: voxel size must be positive");
    TriangleMesh mesh = quadsOf(*levelSetOf(sculpture, voxelSize));
    relax(mesh, sculpture, voxelSize);
    flipEdges(mesh);
    return canonical(mesh);
}

SurfaceCheck checkSurface(const TriangleMesh& mesh) {
    SurfaceCheck check;
    check.vertices = mesh.vertices.size();
    check.triangles = mesh.triangles.size();
    check.volume = signedVolume(mesh);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> halfEdges;
    std::vector<std::uint32_t> parent(mesh.vertices.size());
    for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
    const double sineOfOneDegree = 0.0174524064372835;
    for (const Triangle& t : mesh.triangles) {
        check.area += 0.5 * length(crossOf(mesh, t));
        if (squaredLeastSine(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]) <
            sineOfOneDegree * sineOfOneDegree)
            ++check.slivers;
        for (std::size_t k = 0; k < 3; ++k) {
            halfEdges.emplace_back(t[k], t[(k + 1) % 3]);
            parent[rootOf(parent, t[k])] = rootOf(parent, t[(k + 1) % 3]);
        }
    }
    std::sort(halfEdges.begin(), halfEdges.end());
    for (std::size_t i = 0; i < halfEdges.size(); ++i) {
        const auto& e = halfEdges[i];
        const bool twice = i > 0 && halfEdges[i - 1] == e;
        if (twice || !std::binary_search(halfEdges.begin(), halfEdges.end(),
                                         std::make_pair(e.second, e.first)))
            ++check.badEdges;
    }
    check.eulerNumber = long(check.vertices) - long(halfEdges.size() / 2) + long(check.triangles);

    // Walk around each vertex: its triangles must form one closed fan.
    struct Corner {
        std::uint32_t vertex, next, previous;
    };
    std::vector<Corner> corners;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            corners.push_back({t[k], t[(k + 1) % 3], t[(k + 2) % 3]});
    std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
        return std::tie(a.vertex, a.next) < std::tie(b.vertex, b.next);
    });
    std::size_t seen = 0;
    for (std::size_t i = 0; i < corners.size();) {
        std::size_t end = i;
        while (end < corners.size() && corners[end].vertex == corners[i].vertex) ++end;
        std::uint32_t at = corners[i].next;
        std::size_t steps = 0;
        do {
            std::size_t k = i;
            while (k < end && corners[k].next != at) ++k;
            if (k == end) break;
            at = corners[k].previous;
            ++steps;
        } while (at != corners[i].next && steps < end - i);
        if (steps != end - i || at != corners[i].next) ++check.badVertices;
        ++seen;
        i = end;
    }
    check.badVertices += check.vertices - seen;
    for (std::uint32_t i = 0; i < parent.size(); ++i)
        if (rootOf(parent, i) == i) ++check.pieces;
    return check;
}

std::string plyBytes(const TriangleMesh& mesh, const std::string& comment) {
    std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment " + comment +
                        "\nelement vertex " + std::to_string(mesh.vertices.size()) +
                        "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                        std::to_string(mesh.triangles.size()) +
                        "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec<3>& v : mesh.vertices)
        for (int k = 0; k < 3; ++k) append(bytes, float(v[k]));
    for (const Triangle& t : mesh.triangles) {
        append(bytes, std::uint8_t(3));
        for (const std::uint32_t v : t) append(bytes, std::int32_t(v));
    }
    return bytes;
}

}  // namespace vdbpack
