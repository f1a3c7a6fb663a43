#include "support/generators.h"
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_sides.h"

#include <utility>

TEST_CASE("inside a ball mesh is inside the ball") {
    // Also the vote of three axes, which a clean mesh does not need, and a ball long in z.
    const bool clean = GENERATE(true, false);
    const Vec<3> stretch = GENERATE(Vec<3>{{1, 1, 1}}, Vec<3>{{1, 2, 5}}, Vec<3>{{2, 1, 5}});
    const auto stretched = [&](Vec<3> v) {
        for (int d = 0; d < 3; ++d) v[d] *= stretch[d];
        return v;
    };
    const MeshSides sides(mapped(ballMesh(10, 4), stretched), clean);
    RandomStream random(1, 2);
    for (int i = 0; i < 20000; ++i) {
        const Vec<3> ball = randomPoint(random, 12), p = stretched(ball);
        const double r = length(ball);
        if (r < 9.9) CHECK(sides.inside(p));
        if (r > 10) CHECK_FALSE(sides.inside(p));
    }
}

TEST_CASE("overlaps and inverted shells wind as often as they should") {
    TriangleMesh mesh = ballMesh(10, 4), other = mapped(mesh, [](Vec<3> v) {
                                             v[0] += 6;
                                             return v;
                                         });
    append(mesh, other);
    for (auto& t : other.triangles) std::swap(t[1], t[2]);
    append(mesh, mapped(other, [](Vec<3> v) {
               v[0] += 30;
               return v;
           }));
    const MeshSides sides(mesh, true);
    RandomStream random(5, 6);
    for (int i = 0; i < 5000; ++i) {
        Vec<3> p = randomPoint(random, 12);
        p[0] = 1.8 * p[0] + 10;
        int winds = 0;
        bool isNear = false;
        for (const double center : {0, 6, 36}) {
            const double r = length(p - Vec<3>{{center, 0, 0}});
            isNear = isNear || (r > 9.9 && r < 10.1);
            if (r < 10) winds += center > 6 ? -1 : 1;
        }
        if (!isNear) CHECK(sides.winding(p) == winds);
    }
}

TEST_CASE("lines through vertices and edges count right") {
    const auto mesh = ballMesh(10, 3);
    const MeshSides sides(mesh, true);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 7) {
        const auto& t = mesh.triangles[i];
        const Vec<3> a = mesh.vertices[t[0]], middle = (a + mesh.vertices[t[1]]) * 0.5;
        for (Vec<3> p : {a, middle}) {
            p[2] = 0.25;
            const double flat = p[0] * p[0] + p[1] * p[1];
            if (flat < 95) CHECK(sides.inside(p));
            p[2] = 10.5;
            CHECK_FALSE(sides.inside(p));
        }
    }
}

TEST_CASE("a hole does not flip the vote") {
    auto mesh = ballMesh(10, 4);
    mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 3);
    const MeshSides sides(mesh, false);
    RandomStream random(3, 4);
    int wrong = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vec<3> p = randomPoint(random, 12);
        const double r = length(p);
        if (r < 9.5 && !sides.inside(p)) ++wrong;
        if (r > 10.5 && sides.inside(p)) ++wrong;
    }
    CHECK(wrong <= 5);
}

TEST_CASE("two fans of 100,000 long triangles are within the limits of memory and exact",
          "[long]") {
    const bool clean = GENERATE(true, false);
    const double angle = GENERATE(0.0, 0.7);
    const Vec<3> axis{{1, 2, 3}};
    const MeshSides sides(rotated(doubleConeMesh(10, 8, 100000), axis, angle), clean);
    RandomStream random(7, 8);
    const Vec<3> u = normalized(axis);
    for (int i = 0; i < 2000; ++i) {
        const Vec<3> p = randomPoint(random, 11);
        // Signed with respect to the surface, in units of the radius; turned with the mesh.
        const double depth = std::hypot(p[0], p[1]) / 10 + std::abs(p[2]) / 8 - 1;
        if (std::abs(depth) < 1e-6) continue;
        const Vec<3> turned = p * std::cos(angle) + cross(u, p) * std::sin(angle) +
                              u * (dot(u, p) * (1 - std::cos(angle)));
        CHECK(sides.inside(turned) == (depth < 0));
    }
}
