#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/mesh_shells.h"

namespace {

/// Edges used by one triangle, by looking at all pairs: an oracle.
std::size_t boundaryEdgesByPairs(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
    return static_cast<std::size_t>(
        std::count_if(uses.begin(), uses.end(), [](const auto& u) { return u.second == 1; }));
}

/// The mesh with triangles in an order drawn from `seed`, each starting at another corner.
TriangleMesh shuffled(TriangleMesh mesh, std::uint64_t seed) {
    RandomStream random(seed, 0);
    for (std::size_t i = mesh.triangles.size(); i > 1; --i)
        std::swap(mesh.triangles[i - 1], mesh.triangles[random.bits() % i]);
    for (auto& t : mesh.triangles)
        std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.bits() % 3), t.end());
    return mesh;
}

std::vector<int> depths(const ShellAnalysis& analysis) {
    std::vector<int> all;
    for (const auto& shell : analysis.shells) all.push_back(shell.depth);
    return all;
}

}  // namespace

TEST_CASE("a cavity is taken off, whichever way its triangles face") {
    const bool inward = GENERATE(false, true);
    const bool outerInward = GENERATE(false, true);
    CAPTURE(inward, outerInward);
    auto mesh = hollowBallMesh(10, 5, 3, inward);
    if (outerInward) mesh = flipped(mesh);
    const auto analysis = analyzeShells(mesh);
    REQUIRE(analysis.shells.size() == 2);
    CHECK(depths(analysis) == std::vector<int>{0, 1});
    CHECK((analysis.shells[0].signedVolume > 0) == !outerInward);
    const double ball = analyzeShells(ballMesh(1, 3)).enclosedVolume();
    CHECK(analysis.enclosedVolume() == Approx(ball * (1000 - 125)).epsilon(1e-12));
}

TEST_CASE("closed components that intersect are counted by pairs") {
    const auto count = [](const TriangleMesh& mesh) { return checkMesh(mesh).intersections; };
    const TriangleMesh ball = ballMesh(10, 4);
    CHECK(count(ball) == 0);
    CHECK(count(merged(ball, ballMesh(10, 4, {{20.1, 0, 0}}))) == 0);
    CHECK(count(hollowBallMesh(10, 5, 3)) == 0);
    // 0.7 % of the volume, and a cavity that pokes out.
    CHECK(count(merged(ball, ballMesh(10, 4, {{18, 0, 0}}))) == 1);
    CHECK(count(merged(ball, ballMesh(5, 3, {{6, 0, 0}}))) == 1);
    CHECK(count(merged(merged(ball, ballMesh(10, 4, {{18, 0, 0}})),
                       ballMesh(10, 4, {{-18, 0, 0}}))) == 2);
    // A spike of the larger one, far from most of its triangles.
    TriangleMesh spiked = ball;
    spiked.vertices[0] = spiked.vertices[0] * 1.6;
    const Vec<3> tip = spiked.vertices[0] * (1 / length(spiked.vertices[0]));
    CHECK(count(merged(spiked, ballMesh(2, 3, tip * 12.2))) == 1);
    // Few large triangles: bars that enter a ball and pass through a bar, boxes 0.3 in one another,
    // of any direction; boxes that touch in a face, and in one from inside.
    const auto bar = boxMesh({{5, -1, -1}}, {{35, 1, 1}});
    CHECK(count(merged(ball, bar)) == 1);
    CHECK(count(merged(flipped(ball), flipped(bar))) == 1);
    // The bar without its part beyond the ball, whose height above y and z is 10 - (y² + z²) / 20.
    const MeshHealth entered = checkMesh(merged(ball, bar));
    CHECK(entered.intersectionVolume == Approx(4 * (5 - 2.0 / 3 / 20)).epsilon(0.02));
    CHECK(length(entered.intersectionAt - Vec<3>{{7.5, 0, 0}}) < 0.1);
    TriangleMesh bars = boxMesh({{-30, -1, -1}}, {{30, 1, 1}});
    for (int i = -2; i <= 2; ++i)
        bars = merged(bars, boxMesh({{10.0 * i - 0.7, -8, -0.6}}, {{10.0 * i + 0.7, 8, 0.6}}));
    CHECK(count(bars) == 5);
    const auto cube = boxMesh({}, {{10, 10, 10}});
    CHECK(count(merged(cube, translated(cube, {{9.7, 0, 0}}))) == 1);
    CHECK(count(merged(cube, translated(cube, {{9.7, 9.7, 9.7}}))) == 1);
    CHECK(count(merged(cube, translated(cube, {{10, 0, 0}}))) == 0);
    CHECK(count(merged(cube, translated(cube, {{10, 4, 3}}))) == 0);
    CHECK(count(merged(cube, boxMesh({{2, 2, 0}}, {{5, 5, 5}}))) == 0);
}

TEST_CASE("nesting is found at any depth and for any order of the triangles") {
    const auto seed = GENERATE(range(1u, 6u));
    CAPTURE(seed);
    TriangleMesh mesh;
    // Five balls in one another, and beside the innermost a second one at the same depth.
    for (int k = 1; k <= 5; ++k) mesh = merged(mesh, ballMesh(10.0 * k, 2));
    mesh = merged(mesh, ballMesh(1, 2, {{15, 0, 0}}));
    mesh = rotated(shuffled(mesh, seed), {{1, 2, 3}}, seed);
    const auto analysis = analyzeShells(mesh);
    CHECK(depths(analysis) == std::vector<int>{0, 1, 2, 3, 4, 4});
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        REQUIRE(analysis.shellOfTriangle[i] < analysis.shells.size());
}

TEST_CASE("rays through edges and corners of a lattice of boxes count right") {
    // Everything on whole numbers: rays from small boxes run along faces, edges and corners.
    auto mesh = boxMesh({{0, 0, 0}}, {{20, 20, 20}});
    mesh = subdivided(subdivided(mesh));
    mesh = merged(mesh, subdivided(boxMesh({{2, 2, 2}}, {{14, 14, 14}})));
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            mesh = merged(mesh, boxMesh({{3.0 + 2 * i, 3.0 + 2 * j, 5.0}},
                                        {{4.0 + 2 * i, 4.0 + 2 * j, 6.0}}));
    mesh = merged(mesh, boxMesh({{25, 5, 5}}, {{26, 6, 6}}));
    const auto analysis = analyzeShells(mesh);
    REQUIRE(analysis.shells.size() == 28);
    CHECK(analysis.shells[0].depth == 0);
    CHECK(analysis.shells[1].depth == 1);
    int atDepthTwo = 0;
    for (const auto& shell : analysis.shells) atDepthTwo += static_cast<int>(shell.depth == 2);
    CHECK(atDepthTwo == 25);
    CHECK(analysis.enclosedVolume() == Approx(8000 - 1728 + 25 + 1).epsilon(1e-12));
}

TEST_CASE("a box encloses another on the inner side of a common wall, not on the outer") {
    const auto large = boxMesh({{0, 0, 0}}, {{10, 10, 10}});
    CHECK(depths(analyzeShells(merged(large, boxMesh({{4, 4, 0}}, {{6, 6, 2}})))) ==
          std::vector<int>{0, 1});
    CHECK(depths(analyzeShells(merged(large, boxMesh({{4, 4, 10}}, {{6, 6, 12}})))) ==
          std::vector<int>{0, 0});
}

TEST_CASE("only closed pieces enclose others") {
    auto outer = ballMesh(10, 2);
    outer.triangles.pop_back();
    const auto analysis = analyzeShells(merged(outer, ballMesh(5, 2)));
    REQUIRE(analysis.shells.size() == 2);
    CHECK(analysis.shells[0].boundaryEdges == 3);
    CHECK(depths(analysis) == std::vector<int>{0, 0});
}

TEST_CASE("boundary edges agree with a count over all pairs") {
    const auto seed = GENERATE(range(1u, 21u));
    CAPTURE(seed);
    RandomStream random(seed, 1);
    auto mesh = merged(torusMesh(5, 2, 12, 8), ballMesh(1, 1));
    mesh = shuffled(mesh, seed);
    mesh.triangles.resize(mesh.triangles.size() - random.bits() % 100);
    const auto analysis = analyzeShells(mesh);
    std::size_t boundary = 0, triangles = 0;
    for (const auto& shell : analysis.shells) {
        boundary += shell.boundaryEdges;
        triangles += shell.triangles;
    }
    CHECK(boundary == boundaryEdgesByPairs(mesh));
    CHECK(triangles == mesh.triangles.size());
}

TEST_CASE("volumes keep their digits far from the origin") {
    const double shift = GENERATE(0.0, 1e4, 1e6);
    CAPTURE(shift);
    // Whole numbers and halves: moving the boxes rounds nothing.
    const auto mesh = translated(
        merged(boxMesh({{0, 0, 0}}, {{10, 10, 10}}), boxMesh({{4.5, 4.5, 4.5}}, {{5, 5, 5}})),
        {{shift, -shift, shift}});
    const auto analysis = analyzeShells(mesh);
    CHECK(depths(analysis) == std::vector<int>{0, 1});
    CHECK(analysis.shells[0].signedVolume == Approx(1000).epsilon(1e-14));
    CHECK(analysis.shells[1].signedVolume == Approx(0.125).epsilon(1e-14));
}

TEST_CASE("triangles that name a vertex twice open no hole and make no piece") {
    auto mesh = boxMesh({{0, 0, 0}}, {{1, 1, 1}});
    mesh.triangles.insert(mesh.triangles.begin(), {0, 0, 1});
    mesh.triangles.push_back({5, 5, 5});
    const auto analysis = analyzeShells(mesh);
    REQUIRE(analysis.shells.size() == 1);
    CHECK(analysis.shells[0].triangles == 14);
    CHECK(analysis.shells[0].boundaryEdges == 0);
    CHECK(analysis.enclosedVolume() == Approx(1));
}

TEST_CASE("thousands of pieces are nested in linear time", "[long]") {
    TriangleMesh mesh = boxMesh({{-1, -1, -1}}, {{61, 61, 61}});
    const auto ball = ballMesh(0.4, 0);
    mesh.vertices.reserve(30000 * ball.vertices.size());
    for (int i = 0; i < 30; ++i)
        for (int j = 0; j < 30; ++j)
            for (int k = 0; k < 30; ++k)
                mesh = merged(std::move(mesh), translated(ball, {{2.0 * i, 2.0 * j, 2.0 * k}}));
    const auto analysis = analyzeShells(mesh);
    REQUIRE(analysis.shells.size() == 27001);
    const double one = analyzeShells(ball).enclosedVolume();
    CHECK(analysis.enclosedVolume() == Approx(62.0 * 62 * 62 - 27000 * one).epsilon(1e-10));
}
