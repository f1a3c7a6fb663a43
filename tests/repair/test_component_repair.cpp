#include "support/generators.h"
#include "support/sound_mesh.h"
#include "support/test.h"

#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/welding.h"
#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/repair/solid_relations.h"

namespace {

RepairedMesh separately(const TriangleMesh& mesh, double voxelSize = 0,
                        NestedShells nested = NestedShells::cavity) {
    RepairOptions options;
    options.components = RepairComponents::separate;
    options.voxelSize = voxelSize;
    options.nested = nested;
    return repairMesh(mesh, options);
}

/// The mesh without the triangles whose centers lie within `radius` of `at`.
TriangleMesh pierced(const TriangleMesh& mesh, const Vec<3>& at, double radius) {
    TriangleMesh rest;
    rest.vertices = mesh.vertices;
    for (const auto& t : mesh.triangles) {
        const Vec<3> center =
            (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) * (1.0 / 3);
        if (length(center - at) > radius) rest.triangles.push_back(t);
    }
    return rest;
}

double volumeOf(const TriangleMesh& mesh) {
    return checkMesh(mesh).enclosedVolume;
}

}  // namespace

TEST_CASE("bones closer than a voxel stay apart if they are repaired separately") {
    // A row of boxes 0.1 mm apart, each with a flap that makes its surface intersect itself.
    TriangleMesh row;
    const int count = 4;
    for (int i = 0; i < count; ++i) {
        row = merged(row, boxMesh({{10.1 * i, 0, 0}}, {{10.1 * i + 10, 10, 10}}));
        row = merged(row, boxMesh({{10.1 * i + 4, 4, 4}}, {{10.1 * i + 6, 6, 12}}));
    }
    RepairOptions options;
    options.voxelSize = 0.5;
    CHECK(checkMesh(repairMesh(row, options).mesh).shells == 1);
    const auto repaired = separately(row, 0.5);
    requireSound(repaired.mesh);
    CHECK(checkMesh(repaired.mesh).shells == count);
    REQUIRE(repaired.report.changes);
    CHECK(repaired.report.changes->fusedInto == count);
    CHECK(volumeOf(repaired.mesh) == Approx(count * (1000 + 2 * 2 * 2)).epsilon(0.01));
}

TEST_CASE("bones that touch stay apart if they are repaired separately") {
    // Boxes that share a face, an edge, and a corner.
    const Vec<3> shift = GENERATE(Vec<3>{{1, 0, 0}}, Vec<3>{{1, 1, 0}}, Vec<3>{{1, 1, 1}});
    const auto box = boxMesh({{0, 0, 0}}, {{1, 1, 1}});
    const auto mesh = welded(merged(box, translated(box, shift)));
    REQUIRE(mesh.vertices.size() < 16);
    const auto repaired = separately(mesh);
    requireSound(repaired.mesh);
    CHECK(checkMesh(repaired.mesh).shells == 2);
    CHECK(volumeOf(repaired.mesh) == Approx(2).epsilon(1e-12));
    CHECK(repaired.report.changes->fusedInto == 0);
}

TEST_CASE("an open bone is closed without its neighbor") {
    // Two balls 0.02 mm apart; the surface of one is missing where they almost touch.
    const auto left = ballMesh(10, 4), right = ballMesh(10, 4, {{20.02, 0, 0}});
    const auto repaired = separately(merged(pierced(left, {{10, 0, 0}}, 2), right));
    requireSound(repaired.mesh);
    const auto health = checkMesh(repaired.mesh);
    CHECK(health.shells == 2);
    CHECK(volumeOf(repaired.mesh) == Approx(volumeOf(left) + volumeOf(right)).epsilon(0.002));
    CHECK(repaired.report.holesFilled == 1);
    CHECK(repaired.report.changes->before.holes == 1);
}

TEST_CASE("bones that intersect are fused even if they are repaired separately") {
    const auto mesh =
        merged(merged(ballMesh(10, 3), ballMesh(6, 3, {{12, 0, 0}})), ballMesh(5, 3, {{0, 40, 0}}));
    const auto repaired = separately(mesh);
    requireSound(repaired.mesh);
    CHECK(checkMesh(repaired.mesh).shells == 2);
    CHECK(repaired.report.changes->fusedComponents == 2);
    bool warned = false;
    for (const auto& warning : repairWarnings(repaired.report, "spine.stl"))
        warned = warned || warning.find("fused 2 components into 1") != std::string::npos;
    CHECK(warned);
    // The third ball keeps its triangles.
    const auto alone = analyzeShells(repaired.mesh).shells.back();
    CHECK(alone.triangles == ballMesh(5, 3).triangles.size());
}

TEST_CASE("cavities stay cavities if components are repaired separately") {
    // A canal in a bone with a hole, and a loose body in the canal.
    const auto outer = ballMesh(10, 4), canal = ballMesh(6, 3), loose = ballMesh(2, 3);
    const bool inward = GENERATE(true, false);
    const auto mesh =
        merged(merged(pierced(outer, {{10, 0, 0}}, 1.5), inward ? flipped(canal) : canal), loose);
    const auto hollow = separately(mesh);
    requireSound(hollow.mesh);
    CHECK(volumeOf(hollow.mesh) ==
          Approx(volumeOf(outer) - volumeOf(canal) + volumeOf(loose)).epsilon(0.001));
    CHECK(hollow.report.changes->after.components == 2);
    CHECK(hollow.report.changes->after.cavities == 1);
    const auto solid = separately(mesh, 0, NestedShells::solid);
    requireSound(solid.mesh);
    CHECK(volumeOf(solid.mesh) == Approx(volumeOf(outer)).epsilon(0.001));
    CHECK(solid.report.changes->removed == 2);
}

TEST_CASE("separate components without defects come back as they are") {
    const auto mesh = merged(hollowBallMesh(10, 5, 3), torusMesh(30, 5, 40, 20));
    const auto repaired = separately(mesh);
    CHECK(repaired.report.method == RepairReport::Method::none);
    CHECK(repaired.mesh.triangles == mesh.triangles);
    CHECK(repaired.mesh.vertices == mesh.vertices);
}

TEST_CASE("a mesh that is in the file twice is one bone") {
    const auto ball = ballMesh(10, 3);
    auto twice = ball;
    twice.triangles.insert(twice.triangles.end(), ball.triangles.begin(), ball.triangles.end());
    const auto repaired = separately(twice);
    requireSound(repaired.mesh);
    CHECK(volumeOf(repaired.mesh) == Approx(volumeOf(ball)).epsilon(1e-12));
}

TEST_CASE("loose triangles are removed and reported") {
    auto mesh = ballMesh(10, 3);
    for (int i = 0; i < 3; ++i) {
        const double x = 20 + i;
        const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {{{x, 0, 0}}, {{x, 1, 0}}, {{x, 0, 1}}});
        mesh.triangles.push_back({n, n + 1, n + 2});
    }
    const auto repaired = separately(mesh);
    requireSound(repaired.mesh);
    CHECK(repaired.report.changes->fragmentsRemoved == 3);
    CHECK(checkMesh(repaired.mesh).shells == 1);
}

TEST_CASE("solids are apart, intersect, or lie inside each other") {
    using Relation = SolidRelation;
    const auto relation = [](const TriangleMesh& a, const TriangleMesh& b) {
        const Relation there = relationOf(Solid(a), Solid(b));
        const Relation back = relationOf(Solid(b), Solid(a));
        const bool mirrored = there == Relation::inside   ? back == Relation::around
                              : there == Relation::around ? back == Relation::inside
                                                          : back == there;
        CHECK(mirrored);
        return there;
    };
    const auto ball = ballMesh(10, 3);
    CHECK(relation(ball, ballMesh(10, 3, {{15, 0, 0}})) == Relation::intersect);
    CHECK(relation(ball, ballMesh(9, 3, {{13, 13, 0}})) == Relation::intersect);
    CHECK(relation(ball, ballMesh(8, 3, {{13, 13, 0}})) == Relation::apart);
    CHECK(relation(ball, ballMesh(5, 3, {{3, 0, 0}})) == Relation::around);
    CHECK(relation(boxMesh({{-1, -1, -1}}, {{1, 1, 1}}), ball) == Relation::inside);
    CHECK(relation(ball, ball) == Relation::intersect);
    // Bars across each other, with no vertex inside the other.
    CHECK(relation(boxMesh({{-9, -1, -1}}, {{9, 1, 1}}),
                   boxMesh({{-0.5, -9, -0.5}}, {{0.5, 9, 0.5}})) == Relation::intersect);
    // Boxes on one lattice: all crossings lie on edges.
    CHECK(relation(boxMesh({{0, 0, 0}}, {{2, 2, 2}}), boxMesh({{1, 0, 0}}, {{3, 2, 2}})) ==
          Relation::intersect);
    CHECK(relation(boxMesh({{0, 0, 0}}, {{2, 2, 2}}), boxMesh({{2, 0, 0}}, {{3, 2, 2}})) ==
          Relation::apart);
    CHECK(relation(boxMesh({{0, 0, 0}}, {{2, 2, 2}}), boxMesh({{2, 1, 1}}, {{3, 5, 5}})) ==
          Relation::apart);
}
