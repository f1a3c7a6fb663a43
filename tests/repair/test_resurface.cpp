#include "support/generators.h"
#include "support/sound_mesh.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/repair/marching_cubes.h"
#include "vdbpack/repair/resurface.h"
#include "vdbpack/repair/winding_number.h"

namespace {

Vec<3> cornerPlace(int corner) {
    return {{static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1),
             static_cast<double>(corner >> 2)}};
}

Resurfaced resurfaced(const TriangleMesh& mesh, double voxelSize) {
    return resurface(mesh, WindingNumber(mesh), voxelSize);
}

}  // namespace

TEST_CASE("every case of a cube separates its inside corners") {
    const auto cases = makeCubeLoops();
    REQUIRE(cases[0].empty());
    REQUIRE(cases[255].empty());
    for (int inside = 1; inside < 255; ++inside) {
        CAPTURE(inside);
        std::map<int, int> uses;
        for (const auto& loop : cases[static_cast<std::size_t>(inside)]) {
            REQUIRE(loop.size() >= 3);
            for (std::size_t k = 0; k < loop.size(); ++k) {
                ++uses[loop[k]];
                // Steps run along faces.
                REQUIRE(shareFace(loop[k], loop[(k + 1) % loop.size()]));
            }
        }
        // Each edge between an inside and an outside corner lies on just one loop.
        int changing = 0;
        for (int e = 0; e < 12; ++e) {
            const auto edge = cubeEdge(e);
            const int other = edge.corner | 1 << edge.axis;
            const bool changes = (inside >> edge.corner & 1) != (inside >> other & 1);
            changing += changes;
            REQUIRE(uses[e] == (changes ? 1 : 0));
        }
        REQUIRE(changing > 0);
    }
    // One corner inside: the triangle faces away from it.
    for (int corner = 0; corner < 8; ++corner) {
        const auto& loops = cases[std::size_t{1} << corner];
        REQUIRE(loops.size() == 1);
        REQUIRE(loops[0].size() == 3);
        std::array<Vec<3>, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto edge = cubeEdge(loops[0][k]);
            p[k] = cornerPlace(edge.corner);
            p[k][edge.axis] = 0.5;
        }
        const Vec<3> away = p[0] - cornerPlace(corner);
        CHECK(dot(cross(p[1] - p[0], p[2] - p[0]), away) > 0);
    }
}

TEST_CASE("a surface rebuilt lies on the old one") {
    const Vec<3> center = GENERATE(Vec<3>{{0, 0, 0}}, Vec<3>{{1e4, 1e4, -1e4}});
    const auto ball = ballMesh(10, 5, center);
    const auto made = resurfaced(ball, 0.5);
    requireSound(made.mesh);
    CHECK(checkMesh(made.mesh).eulerNumber == 2);
    CHECK(made.bridgedShare == 0);
    for (const auto& v : made.mesh.vertices) {
        // The ball's triangles lie this deep under the sphere; clamped vertices move 1 % of a
        // voxel.
        CHECK(length(v - center) < 10 + 0.006);
        CHECK(length(v - center) > 10 - 0.02);
    }
}

TEST_CASE("a cavity stays where its wall faces into it") {
    const auto mesh = merged(ballMesh(10, 4), flipped(ballMesh(5, 4)));
    const auto made = resurfaced(mesh, 0.4);
    requireSound(made.mesh);
    const MeshHealth health = checkMesh(made.mesh);
    CHECK(health.shells == 2);
    CHECK(health.enclosedVolume == Approx(4.0 / 3 * kPi * (1000 - 125)).epsilon(0.01));
}

TEST_CASE("an opening is closed near its plane") {
    // A tube of 20 mm without its ends.
    TriangleMesh tube;
    constexpr std::uint32_t kAround = 96;
    for (std::uint32_t i = 0; i < kAround; ++i) {
        const double phi = 2 * kPi * i / kAround;
        for (const double z : {-10.0, 10.0})
            tube.vertices.push_back({{4 * std::cos(phi), 4 * std::sin(phi), z}});
    }
    for (std::uint32_t i = 0; i < kAround; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kAround);
        tube.triangles.push_back({a, b, b + 1});
        tube.triangles.push_back({a, b + 1, a + 1});
    }
    const auto made = resurfaced(tube, 0.2);
    requireSound(made.mesh);
    CHECK(made.bridgedShare > 0.05);
    const MeshHealth health = checkMesh(made.mesh);
    CHECK(health.shells == 1);
    CHECK(health.signedVolume == Approx(kPi * 16 * 20).epsilon(0.03));
    for (const auto& v : made.mesh.vertices) CHECK(std::fabs(v[2]) < 10.5);
}

TEST_CASE("a surface rebuilt is the same for any number of threads") {
    auto mesh = merged(ballMesh(6, 4), ballMesh(4, 3, {{5, 1, 0}}));
    mesh.triangles.erase(mesh.triangles.begin() + 100, mesh.triangles.begin() + 130);
    const auto with = [&](int threads) {
        return withThreads(threads, [&] { return resurfaced(mesh, 0.25).mesh; });
    };
    const auto one = with(1), three = with(3);
    REQUIRE(one.vertices == three.vertices);
    REQUIRE(one.triangles == three.triangles);
}

TEST_CASE("walls thinner than a voxel are reported") {
    // A plate of 20 x 20 x 0.05 under a block.
    const auto mesh =
        merged(boxMesh({{0, 0, 0}}, {{20, 20, 0.05}}), boxMesh({{5, 5, -5}}, {{10, 10, 2}}));
    const auto made = resurfaced(mesh, 0.5);
    CHECK(made.thinArea == Approx(375).epsilon(0.2));
}

TEST_CASE("a lattice that cannot be is refused") {
    REQUIRE_THROWS_AS(resurfaced(ballMesh(10, 2), 1e-6), ResourceError);
}
