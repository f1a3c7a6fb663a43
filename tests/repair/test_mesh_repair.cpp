#include "support/generators.h"
#include "support/sound_mesh.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/welding.h"
#include "vdbpack/repair/facing.h"
#include "vdbpack/repair/hole_filling.h"
#include "vdbpack/repair/mesh_repair.h"

namespace {

double volumeOf(const TriangleMesh& mesh) {
    return checkMesh(mesh).enclosedVolume;
}

/// Common volume of balls of radii R and r at a distance d (Weisstein, "Sphere-Sphere
/// Intersection").
double lensVolume(double R, double r, double d) {
    return kPi * std::pow(R + r - d, 2) *
           (d * d + 2 * d * r - 3 * r * r + 2 * d * R + 6 * r * R - 3 * R * R) / (12 * d);
}

/// Without, or with turned, a random share of the triangles.
TriangleMesh damaged(const TriangleMesh& mesh, double share, bool turn, std::uint64_t seed) {
    RandomStream random(seed, 7);
    TriangleMesh result;
    result.vertices = mesh.vertices;
    for (auto t : mesh.triangles) {
        if (random.uniform() < share) {
            if (!turn) continue;
            std::swap(t[1], t[2]);
        }
        result.triangles.push_back(t);
    }
    return result;
}

}  // namespace

TEST_CASE("a sound mesh comes back as it is") {
    const auto mesh =
        GENERATE(ballMesh(10, 3), torusMesh(8, 3, 40, 20), boxMesh({{0, 0, 0}}, {{1, 2, 3}}));
    const auto repaired = repairMesh(mesh);
    CHECK(repaired.report.method == RepairReport::Method::none);
    CHECK(repaired.mesh.vertices == mesh.vertices);
    CHECK(repaired.mesh.triangles == mesh.triangles);
    CHECK(repaired.report.doubtfulVolume == 0);
}

TEST_CASE("a ball that lost triangles keeps its volume") {
    const auto ball = ballMesh(10, 4);
    const double volume = volumeOf(ball);
    const auto [share, tolerance] =
        GENERATE(table<double, double>({{0.01, 0.01}, {0.1, 0.02}, {0.3, 0.05}}));
    const auto seed = GENERATE(range(1u, 4u));
    CAPTURE(share, seed);
    const auto repaired = repairMesh(damaged(ball, share, false, seed));
    requireSound(repaired.mesh);
    CHECK(repaired.report.holesFilled > 0);
    CHECK(std::fabs(volumeOf(repaired.mesh) / volume - 1) < tolerance);
}

TEST_CASE("a ball with turned triangles is turned back") {
    const auto ball = ballMesh(10, 4);
    const double share = GENERATE(0.01, 0.1, 0.3, 0.5, 1.0);
    CAPTURE(share);
    const auto repaired = repairMesh(damaged(ball, share, true, 3));
    requireSound(repaired.mesh);
    CHECK(repaired.report.method == RepairReport::Method::triangles);
    CHECK(volumeOf(repaired.mesh) == Approx(volumeOf(ball)).epsilon(1e-12));
    CHECK(repaired.mesh.triangles.size() == ball.triangles.size());
}

TEST_CASE("a ball without its cap is closed by a plane") {
    // The cap above a circle is missing: its plane is where the winding number is 1/2.
    auto ball = uvBallMesh(10, 60, 120);
    TriangleMesh open;
    open.vertices = ball.vertices;
    const double rim = 10 * std::cos(kPi * 24 / 60), top = rim + 1e-6;
    for (const auto& t : ball.triangles)
        if (ball.vertices[t[0]][2] < top && ball.vertices[t[1]][2] < top &&
            ball.vertices[t[2]][2] < top)
            open.triangles.push_back(t);
    const auto repaired = repairMesh(open);
    requireSound(repaired.mesh);
    const double below = kPi * (2000.0 / 3 + 100 * rim - rim * rim * rim / 3);
    CHECK(volumeOf(repaired.mesh) == Approx(below).epsilon(0.01));
    CHECK(repaired.report.doubtfulVolume > 0);
}

TEST_CASE("copies, turned copies and collapsed triangles go") {
    auto mesh = ballMesh(10, 3);
    const double volume = volumeOf(mesh);
    const std::size_t count = mesh.triangles.size();
    for (std::size_t i = 0; i < count; i += 5) {
        auto t = mesh.triangles[i];
        if (i % 2 == 0) std::swap(t[0], t[1]);
        mesh.triangles.push_back(t);
        mesh.triangles.push_back({t[0], t[1], t[1]});
    }
    const auto repaired = repairMesh(mesh);
    requireSound(repaired.mesh);
    CHECK(repaired.report.duplicates == mesh.triangles.size() - count);
    CHECK(volumeOf(repaired.mesh) == Approx(volume).epsilon(1e-12));
}

TEST_CASE("pieces that cut through each other become one") {
    const auto mesh = merged(ballMesh(10, 4), ballMesh(6, 4, {{9, 0, 0}}));
    const auto repaired = repairMesh(mesh);
    requireSound(repaired.mesh);
    CHECK(repaired.report.method == RepairReport::Method::resurfaced);
    CHECK(checkMesh(repaired.mesh).shells == 1);
    const double lens = lensVolume(10, 6, 9);
    const double both = Measure<3>::ball(10) + Measure<3>::ball(6) - lens;
    CHECK(volumeOf(repaired.mesh) == Approx(both).epsilon(0.01));
    CHECK(repaired.report.overlapVolume == Approx(lens).epsilon(0.1));
}

TEST_CASE("bars of few triangles that cross become one") {
    const auto bars =
        merged(boxMesh({{-15, -2, -2}}, {{15, 2, 2}}), boxMesh({{-2, -15, -2}}, {{2, 15, 2}}));
    const auto repaired = repairMesh(bars);
    requireSound(repaired.mesh);
    CHECK(analyzeShells(repaired.mesh).shells.size() == 1);
    CHECK(volumeOf(repaired.mesh) == Approx(2 * 480 - 64).epsilon(0.02));
}

TEST_CASE("a nested shell bounds a cavity unless it is said to be solid") {
    const bool inward = GENERATE(true, false);
    auto inner = ballMesh(5, 3);
    if (inward) inner = flipped(inner);
    // A few holes in both: the shells are no longer closed.
    auto mesh = damaged(merged(ballMesh(10, 4), inner), 0.02, false, 5);
    RepairOptions options;
    options.nested = GENERATE(NestedShells::cavity, NestedShells::solid);
    const auto repaired = repairMesh(mesh, options);
    requireSound(repaired.mesh);
    const double outerVolume = volumeOf(ballMesh(10, 4));
    const double cavity = options.nested == NestedShells::cavity ? volumeOf(ballMesh(5, 3)) : 0;
    CHECK(volumeOf(repaired.mesh) == Approx(outerVolume - cavity).epsilon(0.002));
}

TEST_CASE("a wall inside a solid is taken out") {
    // A box in the middle of a ball, touching nothing, said to be solid.
    const auto mesh = merged(ballMesh(10, 3), boxMesh({{-1, -1, -1}}, {{1, 1, 1}}));
    RepairOptions options;
    options.nested = NestedShells::solid;
    const auto repaired = repairMesh(mesh, options);
    CHECK(repaired.report.method == RepairReport::Method::triangles);
    CHECK(repaired.report.dropped == 12);
    CHECK(repaired.report.changes->removed == 1);
    CHECK(repaired.report.changes->removedVolume == Approx(8));
    CHECK_THAT(repairWarnings(repaired.report, "bone.stl").front(),
               Catch::Matchers::Contains("removed 1 surface component"));
    CHECK(repaired.mesh.triangles.size() == ballMesh(10, 3).triangles.size());
    CHECK(volumeOf(repaired.mesh) == Approx(volumeOf(ballMesh(10, 3))).epsilon(1e-12));
}

TEST_CASE("solids that touch along an edge part there") {
    // Two cubes that share an edge, welded.
    TriangleMesh mesh = boxMesh({{0, 0, 0}}, {{1, 1, 1}});
    const TriangleMesh other = boxMesh({{1, 1, 0}}, {{2, 2, 1}});
    const auto shift = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto place = [&](std::uint32_t v) {
        for (std::uint32_t i = 0; i < shift; ++i)
            if (mesh.vertices[i] == other.vertices[v]) return i;
        return v + shift;
    };
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles)
        mesh.triangles.push_back({place(t[0]), place(t[1]), place(t[2])});
    if (GENERATE(false, true))
        for (std::size_t i = 0; i < other.triangles.size(); ++i)
            std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
    REQUIRE(checkMesh(mesh).nonManifoldEdges == 1);
    const auto repaired = repairMesh(mesh);
    requireSound(repaired.mesh);
    CHECK(repaired.report.method == RepairReport::Method::triangles);
    CHECK(checkMesh(repaired.mesh).shells == 2);
    CHECK(volumeOf(repaired.mesh) == Approx(2).epsilon(1e-12));
}

TEST_CASE("solids with a wall in common keep their volume") {
    const auto core = ballMesh(5, 3), shell = merged(ballMesh(10, 3), flipped(core));
    const auto box = boxMesh({{0, 0, 0}}, {{2, 2, 2}}), beside = boxMesh({{2, 0, 0}}, {{4, 2, 2}});
    const bool nested = GENERATE(true, false);
    const auto mesh =
        welded(nested ? GENERATE_COPY(merged(shell, core), merged(core, shell))
                      : GENERATE_COPY(merged(box, beside), merged(box, flipped(beside)),
                                      merged(flipped(box), beside)));
    const double volume = nested ? volumeOf(ballMesh(10, 3)) : 16;
    REQUIRE(checkMesh(mesh).duplicateTriangles > 0);
    CHECK(checkMesh(mesh).enclosedVolume == Approx(volume));
    const auto repaired = repairMesh(mesh);
    requireSound(repaired.mesh);
    CHECK(volumeOf(repaired.mesh) == Approx(volume));
    CHECK(checkMesh(repaired.mesh).shells == 1);
}

TEST_CASE("floating pieces stay and face outward") {
    const auto mesh = merged(ballMesh(10, 3), flipped(ballMesh(2, 2, {{20, 0, 0}})));
    const auto repaired = repairMesh(mesh);
    requireSound(repaired.mesh);
    CHECK(repaired.report.turned == ballMesh(2, 2).triangles.size());
    CHECK(volumeOf(repaired.mesh) == Approx(volumeOf(mesh)));
}

TEST_CASE("rims that touch at a vertex are filled apart") {
    auto ball = ballMesh(10, 2);
    // All triangles but those around vertex 0, of which every other stays.
    TriangleMesh open;
    open.vertices = ball.vertices;
    int around = 0;
    for (const auto& t : ball.triangles) {
        const bool at = t[0] == 0 || t[1] == 0 || t[2] == 0;
        if (at && around++ % 2 == 0) continue;
        open.triangles.push_back(t);
    }
    auto filled = open;
    const HoleFilling filling = fillHoles(filled);
    CHECK(filling.left == 0);
    CHECK(filled.triangles.size() == ball.triangles.size());
    requireSound(filled);
    CHECK(volumeOf(filled) == Approx(volumeOf(ball)).epsilon(1e-12));
}

TEST_CASE("what has no inside is refused") {
    TriangleMesh one;
    one.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
    one.triangles = {{0, 1, 2}};
    CHECK_THROWS_AS(repairMesh(one), InputError);
    CHECK_THROWS_AS(repairMesh(TriangleMesh{}), InputError);
    CHECK_THROWS_WITH(repairMesh(merged(ballMesh(1, 2), ballMesh(1, 2, {{1e-6, 0, 0}}))),
                      Catch::Matchers::Contains("two of its components"));
    RepairOptions options;
    options.voxelSize = -1;
    CHECK_THROWS_AS(repairMesh(ballMesh(1, 1), options), ParameterError);
}

TEST_CASE("loose triangles are refused before they are remeshed") {
    RandomStream random(3, 1);
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const Vec<3> at{{random.uniform() * 30, random.uniform() * 30, random.uniform() * 30}};
        for (int k = 0; k < 3; ++k)
            mesh.vertices.push_back(at +
                                    Vec<3>{{random.uniform(), random.uniform(), random.uniform()}});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    double furthest = 0;  // remeshing reports 0.4 and more
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) { furthest = std::max(furthest, p.fraction); };
    CHECK_THROWS_AS(repairMesh(mesh, {}, callbacks), InputError);
    CHECK(furthest == 0);
}

TEST_CASE("the inside of one mesh without that of another") {
    const auto outer = ballMesh(10, 4);
    const auto inner = ballMesh(6, 4, {{7, 0, 0}});  // pokes out
    const auto cut = subtractMesh(outer, inner);
    requireSound(cut.mesh);
    CHECK(volumeOf(cut.mesh) == Approx(Measure<3>::ball(10) - lensVolume(10, 6, 7)).epsilon(0.01));
}
