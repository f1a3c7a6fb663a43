#include "support/test.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_axes.h"
#include "vdbpack/repair/mesh_repair.h"

#include <cmath>

namespace {

TriangleMesh moved(TriangleMesh mesh, double angle, const Vec<3>& by) {
    for (Vec<3>& v : mesh.vertices)
        v = by + Vec<3>{{std::cos(angle) * v[0] - std::sin(angle) * v[1],
                         std::sin(angle) * v[0] + std::cos(angle) * v[1], v[2]}};
    return mesh;
}

/// A prism of `sides` sides along x, about the origin.
TriangleMesh prism(double radius, double length, std::uint32_t sides) {
    TriangleMesh mesh;
    for (std::uint32_t k = 0; k < sides; ++k) {
        const double angle = 2 * kPi * k / sides;
        const double y = radius * std::cos(angle), z = radius * std::sin(angle);
        for (const double x : {-length / 2, length / 2}) mesh.vertices.push_back({{x, y, z}});
    }
    mesh.vertices.push_back({{-length / 2, 0, 0}});
    mesh.vertices.push_back({{length / 2, 0, 0}});
    for (std::uint32_t k = 0; k < sides; ++k) {
        const std::uint32_t a = 2 * k, b = 2 * ((k + 1) % sides);
        mesh.triangles.push_back({a, b, b + 1});
        mesh.triangles.push_back({a, b + 1, a + 1});
        mesh.triangles.push_back({2 * sides, b, a});
        mesh.triangles.push_back({2 * sides + 1, a + 1, b + 1});
    }
    return mesh;
}

PrincipalAxes<3> axesOf(const TriangleMesh& mesh) {
    return principalAxes(mesh, analyzeMesh(mesh)).value();
}

}  // namespace

TEST_CASE("principal axes of a box are its edges, and spreads those of its moments") {
    const Vec<3> at{{1000, -2000, 500}};
    const auto box = moved(boxMesh({{{-3, -10, -5}}, {{3, 10, 5}}}), 0.3, at);
    TriangleMesh inward = box;
    for (auto& t : inward.triangles) std::swap(t[0], t[1]);
    for (const TriangleMesh& mesh : {box, inward}) {
        const auto axes = axesOf(mesh);
        CHECK(length(axes.center - at) < 1e-9);
        const double lengths[] = {20, 10, 6};
        for (int d = 0; d < 3; ++d) {
            CHECK(axes.lengths[d] == Approx(lengths[d]));
            CHECK(axes.spread[d] == Approx(lengths[d] / std::sqrt(12.0)));
        }
        CHECK(std::fabs(axes.axes[0][0]) == Approx(std::sin(0.3)));
        CHECK(axes.axes[1][2] == Approx(1));
        CHECK(dot(cross(axes.axes[0], axes.axes[1]), axes.axes[2]) == Approx(1));
        CHECK(axes.isLong());
    }
}

TEST_CASE("a turned cylinder has its axis, and the moments of a cylinder") {
    const double r = 4, l = 30, angle = 1.1;
    const auto axes = axesOf(moved(prism(r, l, 720), angle, {{7, 8, 9}}));
    CHECK(length(axes.axes[0] - Vec<3>{{std::cos(angle), std::sin(angle), 0}}) < 1e-9);
    CHECK(axes.lengths[0] == Approx(l));
    CHECK(axes.spread[0] == Approx(l / std::sqrt(12.0)));
    CHECK(axes.spread[1] == Approx(r / 2).epsilon(1e-4));
    CHECK(axes.spread[2] == Approx(r / 2).epsilon(1e-4));
}

TEST_CASE("a cavity is not of the solid, and an open mesh has no axes") {
    // A cube of side 4 without one of side 2 at the end of x.
    TriangleMesh mesh = joinedAsCavity(boxMesh({{{-2, -2, -2}}, {{2, 2, 2}}}),
                                       boxMesh({{{-0.5, -1, -1}}, {{1.5, 1, 1}}}));
    const auto axes = axesOf(mesh);
    const double mean = -0.5 * 8 / 56;
    CHECK(axes.center[0] == Approx(mean));
    // Along x: 64 * 16 / 12 less 8 * (4 / 12 + 0.25), about the common center.
    const double along = (64 * 16.0 / 12 - 8 * (4.0 / 12 + 0.25)) / 56 - mean * mean;
    const double across = (64 * 16.0 / 12 - 8 * 4.0 / 12) / 56;
    CHECK(axes.spread[0] * axes.spread[0] == Approx(std::max(along, across)));
    CHECK(axes.spread[2] * axes.spread[2] == Approx(std::min(along, across)));
    CHECK_FALSE(axes.isLong());
    mesh.triangles.pop_back();
    CHECK_FALSE(principalAxes(mesh, analyzeMesh(mesh)));
}
