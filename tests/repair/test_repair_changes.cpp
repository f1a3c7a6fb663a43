#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/repair/repair_changes.h"

#include <nlohmann/json.hpp>

namespace {

/// A mesh without the triangles whose corners all satisfy `isGone`.
template <typename F>
TriangleMesh without(const TriangleMesh& mesh, F&& isGone) {
    TriangleMesh rest;
    rest.vertices = mesh.vertices;
    for (const auto& t : mesh.triangles)
        if (!std::all_of(t.begin(), t.end(), [&](auto v) { return isGone(mesh.vertices[v]); }))
            rest.triangles.push_back(t);
    return rest;
}

std::string warningsOf(const RepairedMesh& repaired) {
    std::string all;
    for (const auto& warning : repairWarnings(repaired.report, "bone.stl")) all += warning + "\n";
    return all;
}

}  // namespace

TEST_CASE("the topology of a surface counts what the eye counts") {
    const auto hollow = topologyOf(hollowBallMesh(10, 5, 3));
    CHECK(hollow.components == 1);
    CHECK(hollow.cavities == 1);
    CHECK(hollow.eulerNumber == 4);
    CHECK(hollow.handles == 0);

    auto ring = torusMesh(8, 3, 40, 20);
    CHECK(topologyOf(ring).handles == 1);
    ring.triangles.erase(ring.triangles.begin() + 5);
    ring.triangles.erase(ring.triangles.begin() + 500, ring.triangles.begin() + 502);
    const auto open = topologyOf(merged(ring, ballMesh(2, 2)));
    CHECK(open.components == 2);
    CHECK(open.holes == 2);
    CHECK(open.handles == 1);

    const auto sheet = without(ballMesh(5, 3), [](const Vec<3>& v) { return v[2] < 2; });
    CHECK(topologyOf(sheet).fragments == 1);
    CHECK(topologyOf(sheet).components == 0);
}

TEST_CASE("a repair that changes nothing has nothing to warn of") {
    const auto repaired = repairMesh(merged(torusMesh(8, 3, 40, 20), ballMesh(2, 2)));
    REQUIRE(repaired.report.changes);
    const auto changes = toJson(repaired.report)["changes"];
    CHECK(changes["before"] == changes["after"]);
    CHECK(repaired.report.changes->after.components == 2);
    CHECK(repaired.report.changes->fusedInto == 0);
    CHECK(warningsOf(repaired).empty());
}

TEST_CASE("a repair names the components that it fused") {
    // Three balls intersect in a row, one is alone.
    auto mesh = merged(ballMesh(10, 4), ballMesh(6, 4, {{12, 0, 0}}));
    mesh = merged(mesh, ballMesh(4, 3, {{20, 0, 0}}));
    mesh = merged(mesh, ballMesh(5, 3, {{0, 40, 0}}));
    const auto repaired = repairMesh(mesh);
    REQUIRE(repaired.report.changes);
    const RepairChanges& changes = *repaired.report.changes;
    CHECK(changes.before.components == 4);
    CHECK(changes.after.components == 2);
    CHECK(changes.fusedInto == 1);
    CHECK(changes.fusedComponents == 3);
    CHECK(changes.fusedVolume == Approx(905).epsilon(0.02));
    CHECK(length(changes.fusedAt - Vec<3>{{12, 0, 0}}) < 0.01);
    CHECK(changes.removed == 0);
    CHECK_THAT(warningsOf(repaired), Contains("bone.stl") && Contains("3 components into 1") &&
                                         Contains("move them apart") &&
                                         !Contains("`repairComponents`"));
    CHECK(toJson(repaired.report)["changes"]["fusedComponents"] == 3);
}

TEST_CASE("components that only lie close are kept apart by a setting, which the report names") {
    // One pair intersects, another is closer than a voxel.
    const auto pair = merged(ballMesh(10, 4), ballMesh(4, 3, {{-12, 0, 0}}));
    const auto mesh = merged(pair, ballMesh(6, 4, {{16.2, 0, 0}}));
    RepairOptions options;
    options.voxelSize = 1;
    const auto repaired = repairMesh(mesh, options);
    REQUIRE(repaired.report.changes->fusedComponents == 3);
    CHECK_THAT(warningsOf(repaired), Contains("`repairComponents` separate") &&
                                         Contains("all but 1 pair that intersects"));
    options.components = RepairComponents::separate;
    const auto apart = repairMesh(mesh, options);
    CHECK(apart.report.changes->fusedComponents == 2);
    CHECK_THAT(warningsOf(apart), Contains("move them apart"));
}

TEST_CASE("a repair counts the holes that it closed") {
    const auto mesh = without(ballMesh(10, 4), [](const Vec<3>& v) {
        return v[2] > 9 || length(v - Vec<3>{{10, 0, 0}}) < 2;
    });
    const auto repaired = repairMesh(mesh);
    const RepairChanges& changes = *repaired.report.changes;
    CHECK(changes.before.holes == 2);
    CHECK(changes.after.holes == 0);
    CHECK(changes.before.handles == changes.after.handles);
    CHECK_THAT(warningsOf(repaired), Contains("2 holes") && !Contains("topology"));
}

TEST_CASE("a changed topology is given with where the surface was cut apart to count it") {
    RepairedMesh repaired;
    repaired.report.before.nonManifoldEdges = 2;
    repaired.report.changes.emplace().before.components = 3;
    CHECK_THAT(warningsOf(repaired),
               Contains("cut apart at 2 non-manifold edges: closed components 3, then 0"));
}

TEST_CASE("a repair that closes a foramen reports the handle that is lost") {
    // A ring with a narrow opening, which large voxels do not resolve, and a ball that intersects.
    const auto mesh = merged(torusMesh(8, 7.8, 60, 40), ballMesh(4, 3, {{15, 0, 0}}));
    RepairOptions options;
    options.voxelSize = 1.5;
    const auto repaired = repairMesh(mesh, options);
    const RepairChanges& changes = *repaired.report.changes;
    CHECK(changes.before.handles == 1);
    CHECK(changes.after.handles == 0);
    CHECK_THAT(warningsOf(repaired), Contains("handles 1, then 0") && Contains("1.5 mm"));
}
