#include "support/generators.h"
#include "support/paths.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/welding.h"

#include <nlohmann/json.hpp>

TEST_CASE("health of a cube") {
    const auto health = checkMesh(boxMesh({{0, 0, 0}}, {{2, 3, 4}}));
    const std::vector<std::size_t> counts{health.triangles, health.vertices, health.edges,
                                          health.pieces, health.shells};
    CHECK(counts == std::vector<std::size_t>{12, 8, 18, 1, 1});
    const std::vector<std::size_t> flaws{health.boundaryEdges,       health.nonManifoldEdges,
                                         health.inconsistentEdges,   health.duplicateTriangles,
                                         health.degenerateTriangles, health.invertedShells};
    CHECK(flaws == std::vector<std::size_t>(6));
    CHECK(health.eulerNumber == 2);
    CHECK(health.area == Approx(2 * (6 + 8 + 12)).epsilon(1e-14));
    CHECK(health.signedVolume == Approx(24).epsilon(1e-14));
    CHECK(health.enclosedVolume == Approx(24).epsilon(1e-14));
    CHECK(health.bounds.lo == Vec<3>{{0, 0, 0}});
    CHECK(health.bounds.hi == Vec<3>{{2, 3, 4}});
    CHECK(health.shellsAtDepth == std::vector<std::size_t>{1});
    CHECK(health.isWatertight());
    CHECK(health.describeLeak().empty());
    CHECK_THAT(toText(health), Contains("watertight"));
}

TEST_CASE("a mesh folded flat is reported to enclose nothing") {
    TriangleMesh mesh;
    mesh.vertices = {{{0, 0, 0}}, {{3, 0, 0}}, {{0, 4, 0}}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
    const auto health = checkMesh(mesh);
    CHECK(health.isClosed());
    CHECK(health.enclosesNothing());
    CHECK_THAT(toText(health), !Contains("watertight"));
}

TEST_CASE("an empty mesh has a health report") {
    const auto health = checkMesh({});
    CHECK(health.triangles == 0);
    CHECK(health.shells == 0);
    CHECK(health.enclosedVolume == 0);
    CHECK(health.bounds.empty());
    CHECK(toJson(health)["bounds"].is_null());
    CHECK(!toText(health).empty());
}

TEST_CASE("the Euler number counts handles and pieces") {
    CHECK(checkMesh(torusMesh(5, 2, 20, 10)).eulerNumber == 0);
    CHECK(checkMesh(ballMesh(5, 3)).eulerNumber == 2);
    CHECK(checkMesh(uvBallMesh(5, 7, 9)).eulerNumber == 2);
    const auto both = checkMesh(merged(torusMesh(5, 2, 20, 10), ballMesh(1, 2)));
    CHECK(both.eulerNumber == 2);
    CHECK(both.pieces == 2);
    CHECK(both.isWatertight());
}

TEST_CASE("area and volume go to those of the ball and the torus") {
    double lastError = 1;
    for (int levels = 2; levels <= 5; ++levels) {
        const auto health = checkMesh(ballMesh(3, levels));
        const double error = 1 - health.signedVolume / Measure<3>::ball(3);
        CHECK(error > 0);
        CHECK(error < lastError / 3);
        lastError = error;
    }
    const auto torus = checkMesh(torusMesh(5, 2, 400, 200));
    CHECK(torus.signedVolume == Approx(2 * kPi * kPi * 5 * 4).epsilon(1e-3));
    CHECK(torus.area == Approx(4 * kPi * kPi * 5 * 2).epsilon(1e-3));
}

TEST_CASE("turning, moving and shuffling a mesh leave its health") {
    auto mesh = merged(torusMesh(5, 2, 20, 10), ballMesh(1, 2, {{20, 0, 0}}));
    mesh.triangles.erase(mesh.triangles.begin() + 17, mesh.triangles.begin() + 20);
    const auto before = checkMesh(mesh);
    const auto after = checkMesh(translated(rotated(mesh, {{1, 1, 0}}, 0.7), {{1e4, -2e4, 3e4}}));
    CHECK(after.boundaryEdges == before.boundaryEdges);
    CHECK(after.shells == before.shells);
    CHECK(after.eulerNumber == before.eulerNumber);
    CHECK(after.area == Approx(before.area).epsilon(1e-10));
    // Open pieces too have a volume that does not depend on the place.
    CHECK(after.signedVolume == Approx(before.signedVolume).epsilon(1e-10));
    CHECK(after.leak->largest.length == Approx(before.leak->largest.length));
}

TEST_CASE("a hole is found, with where it is and how long") {
    // The top of a box is missing: a plane hole, which the volume closes exactly.
    auto mesh = boxMesh({{0, 0, 0}}, {{2, 3, 4}});
    mesh.triangles.erase(std::remove_if(mesh.triangles.begin(), mesh.triangles.end(),
                                        [&](const auto& t) {
                                            return std::all_of(t.begin(), t.end(), [&](auto v) {
                                                return mesh.vertices[v][2] == 4;
                                            });
                                        }),
                         mesh.triangles.end());
    const auto health = checkMesh(mesh);
    CHECK(health.boundaryEdges == 4);
    CHECK(!health.isClosed());
    REQUIRE(health.leak);
    CHECK(health.leak->vertex == 4);
    CHECK(health.leak->position == Vec<3>{{0, 0, 4}});
    CHECK(health.leak->loops == 1);
    CHECK(health.leak->largest.edges == 4);
    CHECK(health.leak->largest.length == Approx(10));
    CHECK(length(health.leak->largest.center - Vec<3>{{1, 1.5, 4}}) < 1e-12);
    CHECK(health.signedVolume == Approx(24).epsilon(1e-12));
    CHECK_THAT(health.describeLeak(),
               Contains("4 boundary edges, first at vertex 4 (0, 0, 4)") && Contains("10 mm"));
    CHECK_THAT(toText(health), Contains("open: 4 boundary edges"));
    const auto json = toJson(health);
    CHECK(json["boundaryEdges"] == 4);
    CHECK(json["closed"] == false);
    CHECK(json["leak"]["largest"]["edges"] == 4);
}

TEST_CASE("of several holes the largest is reported") {
    auto mesh = merged(uvBallMesh(10, 12, 12), ballMesh(1, 1, {{30, 0, 0}}));
    mesh.triangles.pop_back();
    // The cap around the first pole of the large ball.
    mesh.triangles.erase(std::remove_if(mesh.triangles.begin(), mesh.triangles.end(),
                                        [](const auto& t) { return t[0] == 0; }),
                         mesh.triangles.end());
    const auto health = checkMesh(mesh);
    REQUIRE(health.leak);
    CHECK(health.leak->loops == 2);
    CHECK(health.leak->largest.edges == 12);
    CHECK(health.leak->largest.center[2] == Approx(10 * std::cos(kPi / 12)));
}

TEST_CASE("triangles that face the wrong way are counted by edge and by shell") {
    auto mesh = ballMesh(5, 2);
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    const auto one = checkMesh(mesh);
    CHECK(one.inconsistentEdges == 3);
    CHECK(one.isWatertight());

    CHECK(checkMesh(flipped(ballMesh(5, 2))).invertedShells == 1);
    CHECK(checkMesh(hollowBallMesh(10, 5, 2)).invertedShells == 0);
    const auto wrong = checkMesh(hollowBallMesh(10, 5, 2, false));
    CHECK(wrong.invertedShells == 1);
    CHECK(wrong.shellsAtDepth == std::vector<std::size_t>{1, 1});
    CHECK_THAT(toText(wrong), Contains("cavity"));
}

TEST_CASE("copies and triangles without area are counted and dropped") {
    const auto seed = GENERATE(range(1u, 11u));
    CAPTURE(seed);
    RandomStream random(seed, 4);
    const auto clean = ballMesh(5, 2);
    auto dirty = clean;
    for (int i = 0; i < 20; ++i) {
        auto t = clean.triangles[random.bits() % clean.triangles.size()];
        std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.bits() % 3), t.end());
        if (random.bits() % 2 == 0) std::swap(t[0], t[1]);
        dirty.triangles.push_back(t);
    }
    dirty.triangles.push_back({3, 3, 4});
    dirty.triangles.push_back({5, 5, 5});
    const auto health = checkMesh(dirty);
    CHECK(health.duplicateTriangles == 20);
    CHECK(health.degenerateTriangles == 2);
    CHECK(health.nonManifoldEdges > 0);
    const auto again = withoutDuplicates(dirty);
    CHECK(again.triangles == clean.triangles);
    CHECK(withoutDuplicates(again).triangles == clean.triangles);
    CHECK(checkMesh(again).isWatertight());
}

TEST_CASE("without their common wall two boxes are one, and copies are left once") {
    const auto boxes =
        welded(merged(boxMesh({{0, 0, 0}}, {{2, 2, 2}}), boxMesh({{2, 0, 0}}, {{4, 2, 2}})));
    REQUIRE(checkMesh(boxes).duplicateTriangles > 0);
    auto copied = boxes;
    copied.triangles.push_back(boxes.triangles.front());
    const auto joined = checkMesh(withoutDuplicates(copied, false));
    CHECK(joined.isWatertight());
    CHECK(joined.shells == 1);
    CHECK(joined.signedVolume == Approx(16));
}

TEST_CASE("a needle keeps a mesh closed and is counted as degenerate") {
    // The middle of an edge of a box belongs to one face only; a needle joins both sides.
    auto mesh = boxMesh({{0, 0, 0}}, {{2, 2, 2}});
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    auto& t = mesh.triangles[0];
    const auto a = t[0];
    const auto b = t[1];
    const auto c = t[2];
    mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]) * 0.5);
    t = {a, middle, c};
    mesh.triangles.push_back({middle, b, c});
    CHECK(checkMesh(mesh).boundaryEdges == 3);
    mesh.triangles.push_back({a, b, middle});
    const auto health = checkMesh(mesh);
    CHECK(health.degenerateTriangles == 1);
    CHECK(health.isWatertight());
    CHECK(withoutDuplicates(mesh).triangles.size() == mesh.triangles.size());
}

TEST_CASE("pieces are connected by vertices, shells by edges") {
    auto mesh =
        welded(merged(boxMesh({{0, 0, 0}}, {{1, 1, 1}}), boxMesh({{1, 1, 1}}, {{2, 2, 2}})));
    auto health = checkMesh(mesh);
    CHECK(health.vertices == 15);
    CHECK(health.pieces == 1);
    CHECK(health.shells == 2);
    CHECK(health.isWatertight());
    // Boxes that share an edge, which has four triangles.
    mesh = welded(merged(boxMesh({{0, 0, 0}}, {{1, 1, 1}}), boxMesh({{1, 1, 0}}, {{2, 2, 1}})));
    health = checkMesh(mesh);
    CHECK(health.pieces == 1);
    CHECK(health.shells == 2);
    CHECK(health.nonManifoldEdges == 1);
    CHECK(health.isClosed());
    CHECK(!health.isWatertight());
    CHECK(health.enclosedVolume == Approx(2));
}

TEST_CASE("vertices that no triangle names count for nothing") {
    auto mesh = boxMesh({{0, 0, 0}}, {{1, 1, 1}});
    mesh.vertices.push_back({{100, 100, 100}});
    const auto health = checkMesh(mesh);
    CHECK(health.vertices == 8);
    CHECK(health.eulerNumber == 2);
    CHECK(health.bounds.hi == Vec<3>{{1, 1, 1}});
}

TEST_CASE("the bundled meshes are single sound surfaces with the tunnels that they should have") {
    const auto [name, tunnels] = GENERATE(table<const char*, int>(
        {{"femur", 0}, {"mandible", 0}, {"hip", 1}, {"skull", 6}, {"irregular", 0}}));
    CAPTURE(name);
    const auto health = checkMesh(readMesh(kMeshes + "/" + name + ".ply"));
    CHECK(health.isWatertight());
    CHECK(health.shells == 1);
    CHECK(health.inconsistentEdges + health.degenerateTriangles + health.invertedShells == 0);
    CHECK(health.eulerNumber == 2 - 2 * tunnels);
}
