// Meshes by formula, with known properties.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace vdbpack::test {

/// The mesh with every vertex `v` replaced by `f(v)`.
template <typename F>
TriangleMesh mapped(TriangleMesh mesh, F&& f) {
    for (auto& v : mesh.vertices) v = f(v);
    return mesh;
}

inline TriangleMesh translated(TriangleMesh mesh, const Vec<3>& by) {
    return mapped(std::move(mesh), [&](const Vec<3>& v) { return v + by; });
}

inline TriangleMesh scaled(TriangleMesh mesh, double factor) {
    return mapped(std::move(mesh), [&](const Vec<3>& v) { return v * factor; });
}

/// Turned about the origin by `angle` (radians) around `axis` (any length but zero).
inline TriangleMesh rotated(TriangleMesh mesh, const Vec<3>& axis, double angle) {
    const Vec<3> u = normalized(axis);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return mapped(std::move(mesh), [&](const Vec<3>& v) {
        return v * c + cross(u, v) * s + u * (dot(u, v) * (1 - c));
    });
}

/// The same surface with its faces reversed.
inline TriangleMesh flipped(TriangleMesh mesh) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

/// Both meshes in one; vertices are not welded.
inline TriangleMesh merged(TriangleMesh a, const TriangleMesh& b) {
    const auto shift = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const auto& t : b.triangles)
        a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    return a;
}

/// Every triangle split into four at the middles of its sides; the surface does not change.
inline TriangleMesh subdivided(const TriangleMesh& mesh) {
    TriangleMesh fine;
    fine.vertices = mesh.vertices;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        if (a > b) std::swap(a, b);
        const auto [at, isNew] =
            middles.try_emplace({a, b}, static_cast<std::uint32_t>(fine.vertices.size()));
        if (isNew) fine.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]) * 0.5);
        return at->second;
    };
    for (const auto& t : mesh.triangles) {
        const std::uint32_t a = middle(t[0], t[1]);
        const std::uint32_t b = middle(t[1], t[2]);
        const std::uint32_t c = middle(t[2], t[0]);
        fine.triangles.push_back({t[0], a, c});
        fine.triangles.push_back({t[1], b, a});
        fine.triangles.push_back({t[2], c, b});
        fine.triangles.push_back({a, b, c});
    }
    return fine;
}

/// A box with corners `lo` and `hi`, 12 triangles, facing outward.
inline TriangleMesh boxMesh(const Vec<3>& lo, const Vec<3>& hi) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.push_back({{(i & 1) != 0 ? hi[0] : lo[0], (i & 2) != 0 ? hi[1] : lo[1],
                                  (i & 4) != 0 ? hi[2] : lo[2]}});
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& f : kFaces) {
        mesh.triangles.push_back({f[0], f[1], f[2]});
        mesh.triangles.push_back({f[0], f[2], f[3]});
    }
    return mesh;
}

/// A ball made from an icosahedron whose triangles are split into four `levels` times:
/// 20 * 4^levels triangles, vertices on the sphere. Its volume is smaller than the sphere's by
/// about 1.2 / 4^levels of it.
inline TriangleMesh ballMesh(double radius, int levels, const Vec<3>& center = {}) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    TriangleMesh mesh;
    mesh.vertices = {{{-1, g, 0}}, {{1, g, 0}}, {{-1, -g, 0}}, {{1, -g, 0}},
                     {{0, -1, g}}, {{0, 1, g}}, {{0, -1, -g}}, {{0, 1, -g}},
                     {{g, 0, -1}}, {{g, 0, 1}}, {{-g, 0, -1}}, {{-g, 0, 1}}};
    mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int i = 0; i < levels; ++i) {
        mesh = subdivided(mesh);
        for (auto& v : mesh.vertices) v = normalized(v);
    }
    return mapped(std::move(mesh),
                  [&](const Vec<3>& v) { return center + normalized(v) * radius; });
}

/// A ball in rings of latitude: `rings` >= 2 from pole to pole, `sectors` >= 3 around the z axis.
inline TriangleMesh uvBallMesh(double radius, int rings, int sectors, const Vec<3>& center = {}) {
    TriangleMesh mesh;
    const auto at = [&](int ring, int sector) {
        if (ring == 0) return std::uint32_t{0};
        if (ring == rings) return static_cast<std::uint32_t>(1 + (rings - 1) * sectors);
        return static_cast<std::uint32_t>(1 + (ring - 1) * sectors + sector % sectors);
    };
    mesh.vertices.push_back(center + Vec<3>{{0, 0, radius}});
    for (int i = 1; i < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            const double theta = kPi * i / rings;
            const double phi = 2 * kPi * j / sectors;
            mesh.vertices.push_back(center + Vec<3>{{radius * std::sin(theta) * std::cos(phi),
                                                     radius * std::sin(theta) * std::sin(phi),
                                                     radius * std::cos(theta)}});
        }
    mesh.vertices.push_back(center - Vec<3>{{0, 0, radius}});
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            if (i + 1 < rings) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            if (i > 0) mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

/// A torus around the z axis: `major` is the radius of its center line, `minor` of its tube.
inline TriangleMesh torusMesh(double major, double minor, int around, int across) {
    TriangleMesh mesh;
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < across; ++j) {
            const double phi = 2 * kPi * i / around;
            const double theta = 2 * kPi * j / across;
            const double distance = major + minor * std::cos(theta);
            mesh.vertices.push_back(
                {{distance * std::cos(phi), distance * std::sin(phi), minor * std::sin(theta)}});
        }
    const auto at = [&](int i, int j) {
        return static_cast<std::uint32_t>((i % around) * across + j % across);
    };
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < across; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

/// Two cones of `corners` long triangles each, base to base: `radius` around the z axis, `height`
/// to either side.
inline TriangleMesh doubleConeMesh(double radius, double height, std::uint32_t corners) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < corners; ++i) {
        const double phi = 2 * kPi * i / corners;
        mesh.vertices.push_back({{radius * std::cos(phi), radius * std::sin(phi), 0}});
    }
    mesh.vertices.push_back({{0, 0, height}});
    mesh.vertices.push_back({{0, 0, -height}});
    for (std::uint32_t i = 0; i < corners; ++i) {
        const std::uint32_t next = (i + 1) % corners;
        mesh.triangles.push_back({i, next, corners});
        mesh.triangles.push_back({next, i, corners + 1});
    }
    return mesh;
}

/// A ball with a concentric cavity. The cavity's normals point into it (`cavityFacesInward`, as for
/// an oriented surface of the solid) or out of it.
inline TriangleMesh hollowBallMesh(double radius, double cavityRadius, int levels,
                                   bool cavityFacesInward = true) {
    TriangleMesh cavity = ballMesh(cavityRadius, levels);
    if (cavityFacesInward) cavity = flipped(std::move(cavity));
    return merged(ballMesh(radius, levels), cavity);
}

}  // namespace vdbpack::test
