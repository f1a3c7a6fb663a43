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
    int packed(const std::string& options = "") const {
        return vdbPack("pack " + file_ + " --radius constant:1 --quiet -o " + folder_.path() +
                       "/p.csv " + options)
            .code;
    }

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

TEST_CASE("closed components that overlap are fit with a repair only") {
    const Asked asked(merged(ballMesh(10, 3), ballMesh(8, 3, {{9, 0, 0}})));
    REQUIRE(asked.packed() == 3);
    const auto json = asked.json();
    CHECK(json["watertight"] == true);
    CHECK(json["fit"] == "with repair");
    CHECK_THAT(json["reasons"].dump(), Contains("overlap"));
    CHECK(json["withRepair"]["changes"]["fusedComponents"] == 2);
    CHECK(asked.json("--repair-components separate")["withRepair"]["components"] == "separate");
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
}
