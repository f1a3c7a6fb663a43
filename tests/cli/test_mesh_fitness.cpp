// `mesh` decides whether a mesh can be packed, as `pack` does.
#include "support/generators.h"
#include "support/mesh_file.h"
#include "support/test.h"
#include "support/tool.h"

namespace {

/// A mesh in a file, asked in all ways.
class Asked {
public:
    explicit Asked(const TriangleMesh& mesh) : file_(folder_.path() + "/bone.obj") {
        writeObj(mesh, file_);
    }
    nlohmann::json json(const std::string& options = "") const {
        return jsonOf(vdbPack("mesh " + file_ + " --json --quiet " + options));
    }
    Output mesh(const std::string& options) const {
        return vdbPack("mesh " + file_ + " " + options);
    }
    Output pack(const std::string& options) const {
        return vdbPack("pack " + file_ + " --radius constant:1 -o " + folder_.path() + "/p.csv " +
                       options);
    }
    bool verified() const {
        return vdbPack("verify " + folder_.path() + "/p.csv --domain " + file_).code == 0;
    }
    int packed(const std::string& options = "") const { return pack("--quiet " + options).code; }

private:
    TemporaryFolder folder_;
    std::string file_;
};

/// Without every n-th triangle.
TriangleMesh holed(const TriangleMesh& mesh, std::size_t n) {
    TriangleMesh rest;
    rest.vertices = mesh.vertices;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (i % n != 0) rest.triangles.push_back(mesh.triangles[i]);
    return rest;
}

/// Without the first triangles.
TriangleMesh withoutTriangles(TriangleMesh mesh, long n) {
    mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + n);
    return mesh;
}

/// The volume of the domain that a run prints, mm³.
double volumeIn(const Output& run) {
    return std::stod(run.text.substr(run.text.find("volume ") + 7));
}

}  // namespace

TEST_CASE("a closed mesh is fit to be packed, whichever way it faces") {
    const bool inward = GENERATE(false, true);
    auto ball = hollowBallMesh(10, 4, 3);
    if (inward) ball = flipped(ball);
    const Asked asked(ball);
    const auto json = asked.json("--check");
    CHECK(json["fit"] == "yes");
    CHECK(json["reasons"].empty());
    CHECK(json["withRepair"].is_null());
    CHECK(asked.json("--repair --check")["fit"] == "yes");
    CHECK(asked.packed() == 0);
    CHECK_THAT(asked.mesh("").text, Contains("fit to be packed      yes"));
}

TEST_CASE("a mesh with holes is fit with a repair, and what that does is reported") {
    const Asked asked(holed(ballMesh(10, 3), 100));
    const auto json = asked.json();
    CHECK(json["fit"] == "with repair");
    CHECK_THAT(json["reasons"].dump(), Contains("39 boundary edges"));
    CHECK(json["withRepair"]["holesFilled"] == 13);
    CHECK(json["withRepair"]["changes"]["before"]["holes"] == 13);
    CHECK_THAT(json["withRepair"]["warnings"].dump(), Contains("13 holes"));
    const auto checked = asked.mesh("--check");
    CHECK(checked.code == 1);
    CHECK_THAT(checked.text, Contains("--repair") && Contains("13 holes filled") &&
                                 Contains("not fit to be packed as it is"));
    const auto repaired = asked.json("--repair --check");
    CHECK(repaired["fit"] == "with repair");
    CHECK(repaired["repair"]["holesFilled"] == 13);
    CHECK(asked.packed("--repair") == 0);
}

TEST_CASE("a mesh that a run takes with a warning is fit as it is, and its flaw is named") {
    const Asked asked(withoutTriangles(ballMesh(10, 5), 1));
    const auto json = asked.json("--check");
    CHECK(json["fit"] == "yes");
    CHECK_THAT(json["reasons"].dump(), Contains("3 boundary edges") && Contains("--repair"));
    CHECK(asked.mesh("--check").code == 0);
    const Output pack = asked.pack("");
    CHECK(pack.code == 0);
    CHECK_THAT(pack.text, Contains("warning") && Contains("3 boundary edges"));
}

TEST_CASE("a triangle given twice that a run takes with a warning is named") {
    auto ball = ballMesh(10, 5);
    ball.triangles.push_back(ball.triangles.front());
    const Asked asked(ball);
    const auto json = asked.json();
    CHECK(json["fit"] == "yes");
    CHECK_THAT(json["reasons"].dump(), Contains("1 duplicate triangle"));
    const Output pack = asked.pack("");
    CHECK(pack.code == 0);
    CHECK_THAT(pack.text, Contains("1 duplicate triangle"));
}

TEST_CASE("closed components that overlap are fit with a repair only") {
    const Asked asked(merged(ballMesh(10, 3), ballMesh(8, 3, {{9, 0, 0}})));
    REQUIRE(asked.packed() == 3);
    const auto json = asked.json();
    CHECK(json["watertight"] == true);
    CHECK(json["fit"] == "with repair");
    CHECK_THAT(json["reasons"].dump(), Contains("components that intersect"));
    CHECK(json["withRepair"]["changes"]["fusedComponents"] == 2);
    CHECK(asked.json("--repair-components separate")["withRepair"]["components"] == "separate");
}

TEST_CASE("mesh and pack name the overlap of components that is lost, and the remedy") {
    // 4 mm² of 5 mm, less the cap of the ball: 19.9 mm³.
    const Asked asked(merged(ballMesh(10, 5), boxMesh({{5, -1, -1}}, {{35, 1, 1}})));
    const auto json = asked.json();
    CHECK(json["fit"] == "with repair");
    CHECK(json["intersectionVolume"].get<double>() == Approx(19.87).epsilon(0.02));
    CHECK_THAT(json["reasons"].dump(), Contains("1 pair of components that intersect"));
    const Output pack = asked.pack("");
    CHECK(pack.code == 0);
    CHECK_THAT(pack.text, Contains("1 pair of components that intersect, in about 19.") &&
                              Contains("outside") && Contains("--repair"));
    CHECK(volumeIn(asked.pack("--repair")) == Approx(4188.8 + 120 - 19.87).epsilon(0.003));
}

TEST_CASE("mesh, pack and verify judge alike, and the volume is right") {
    const auto cube = boxMesh({}, {{10, 10, 10}}), inner = boxMesh({{3, 3, 3}}, {{7, 7, 7}});
    const auto beside = [&](const Vec<3>& by) { return merged(cube, translated(cube, by)); };
    struct Row {
        const char* name;
        TriangleMesh mesh;
        const char* fit;
        double volume;  // mm³, once repaired if need be
    };
    for (const Row& row : std::vector<Row>{
             {"cubes that share a face", beside({{10, 0, 0}}), "yes", 2000},
             {"cubes that touch in a part of a face", beside({{10, 4, 3}}), "yes", 2000},
             {"cubes that share an edge", beside({{10, 10, 0}}), "yes", 2000},
             {"cubes that share a corner", beside({{10, 10, 10}}), "yes", 2000},
             {"cubes 1e-6 mm apart", beside({{10 + 1e-6, 0, 0}}), "yes", 2000},
             {"nested", merged(cube, flipped(inner)), "yes", 936},
             {"nested, facing alike", merged(cube, inner), "yes", 936},
             {"inside out", merged(flipped(cube), inner), "yes", 936},
             {"nested thrice", merged(merged(boxMesh({{-9, -9, -9}}, {{19, 19, 19}}), cube), inner),
              "yes", 21952 - 936},
             {"given twice", merged(cube, cube), "with repair", 1000},
             {"open", withoutTriangles(cube, 2), "with repair", 1000},
             {"bars that cross",
              merged(boxMesh({{-15, -2, -2}}, {{15, 2, 2}}),
                     boxMesh({{-2, -15, -2}}, {{2, 15, 2}})),
              "with repair", 896}}) {
        CAPTURE(row.name);
        const Asked asked(row.mesh);
        CHECK(asked.json()["fit"] == row.fit);
        const bool fit = row.fit == std::string("yes");
        CHECK(asked.mesh("--check").code == (fit ? 0 : 1));
        CHECK(asked.packed() == (fit ? 0 : 3));
        const Output pack = asked.pack(fit ? "" : "--repair");
        CHECK(pack.code == 0);
        CHECK(volumeIn(pack) == Approx(row.volume).epsilon(0.02));
        if (fit) CHECK(asked.verified());
    }
}

TEST_CASE("what encloses nothing is not fit, not even with a repair") {
    TriangleMesh sheet;
    sheet.vertices = {{{0, 0, 0}}, {{30, 0, 0}}, {{0, 40, 0}}, {{30, 40, 0}}};
    sheet.triangles = {{0, 1, 2}, {1, 3, 2}};
    const bool folded = GENERATE(false, true);
    if (folded) sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
    const Asked asked(sheet);
    const auto json = asked.json();
    CHECK(json["fit"] == "no");
    CHECK(!json["reasons"].empty());
    CHECK(asked.mesh("--check").code == 1);
    CHECK(asked.mesh("").code == 0);
    CHECK(asked.packed() == 3);
    CHECK(asked.packed("--repair") == 3);
}

TEST_CASE("mesh names the unit if the size is unlikely for a bone") {
    const Asked asked(ballMesh(0.1, 2));
    CHECK_THAT(asked.mesh("").text, Contains("--unit") && Contains("fit to be packed      yes"));
    CHECK_THAT(asked.mesh("--unit cm").text, Contains("--unit"));  // 3.5 mm
    CHECK_THAT(asked.mesh("--scale 10").text, !Contains("--unit"));
}
