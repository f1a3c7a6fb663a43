// --repair and --cavities through the program: packed, written, verified against the same surface.
#include "support/generators.h"
#include "support/mesh_file.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/core/rng.h"

namespace {

/// Two balls that cut through each other, without a twentieth of their triangles.
TriangleMesh dirtyMesh() {
    const auto whole = merged(ballMesh(10, 3), ballMesh(6, 3, {{9, 0, 0}}));
    TriangleMesh mesh;
    mesh.vertices = whole.vertices;
    RandomStream random(11, 2);
    for (const auto& t : whole.triangles)
        if (random.uniform() >= 0.05) mesh.triangles.push_back(t);
    return mesh;
}

}  // namespace

TEST_CASE("a dirty mesh is refused, and packed and verified with --repair") {
    const TemporaryFolder folder;
    const std::string mesh = folder.path() + "/dirty.obj", pack = folder.path() + "/p.vdb",
                      surface = folder.path() + "/repaired.stl";
    writeObj(dirtyMesh(), mesh);
    const auto refused = vdbPack("pack " + mesh + " --radius constant:0.6 -o " + pack);
    CHECK(refused.code == 3);
    CHECK_THAT(refused.text,
               Contains("boundary edges") && Contains("vertex") && Contains("--repair"));

    const auto report = jsonOf(vdbPack(
        "pack " + mesh + " --repair --radius constant:0.6 --json -o " + pack + " -o " + surface));
    const auto& repair = report["domain"]["repair"];
    CHECK(repair["method"] == "resurfaced");
    CHECK(repair["before"]["boundaryEdges"] > 100);
    CHECK(repair["changes"]["before"]["components"] == 2);
    CHECK(repair["changes"]["after"]["components"] == 1);
    CHECK(repair["changes"]["fusedComponents"] == 2);
    const std::string warnings = report["warnings"].dump();
    CHECK_THAT(warnings, Contains("fused 2 components into 1") && Contains("closed"));
    CHECK(report["domain"]["boundaryEdges"] == 0);
    CHECK(report["protrusion"]["spheres"] == 0);
    // Against the dirty mesh repaired again, and against what was written.
    for (const std::string& domain : {mesh + " --repair", surface}) {
        const auto checked = jsonOf(vdbPack("verify " + pack + " --json --domain " + domain));
        CHECK(checked["protrusion"]["spheres"] == 0);
        CHECK(checked["hash"] == report["hash"]);
        CHECK(checked["domain"]["meshVolume"].get<double>() ==
              Approx(report["domain"]["meshVolume"].get<double>()).epsilon(1e-12));
    }
}

TEST_CASE("the mesh command repairs, tells of it and writes the surface") {
    const TemporaryFolder folder;
    const std::string mesh = folder.path() + "/dirty.obj", surface = folder.path() + "/sound.stl";
    writeObj(dirtyMesh(), mesh);
    const auto told = vdbPack("mesh " + mesh + " --repair -o " + surface);
    CHECK(told.code == 0);
    CHECK_THAT(told.text, Contains("ambiguous volume") && Contains("watertight"));
    const auto health = jsonOf(vdbPack("mesh " + surface + " --json"));
    CHECK(health["watertight"] == true);
    CHECK(health["shells"] == 1);

    CHECK(vdbPack("mesh " + surface + " -o " + surface).code == 2);
    const auto wrong = vdbPack("mesh " + mesh + " --repair -o " + folder.path() + "/x.obj");
    CHECK(wrong.code == 2);
    CHECK_THAT(wrong.text, Contains(".stl"));
}

TEST_CASE("shells say what lies between two surfaces") {
    const TemporaryFolder folder;
    const auto file = [&](const char* name) { return folder.path() + "/" + name; };
    const auto outer = ballMesh(10, 3), inner = ballMesh(5, 3);
    writeObj(outer, file("outer.obj"));
    writeObj(inner, file("inner.obj"));
    writeObj(ballMesh(5, 3, {{8, 0, 0}}), file("aside.obj"));
    writeObj(merged(outer, inner), file("both.obj"));
    const auto volume = [&](const std::string& words) {
        return jsonOf(vdbPack("pack " + words + " --radius constant:1 --json -o " +
                              file("p.csv")))["domain"]["volume"]
            .get<double>();
    };
    const double outside = volume(file("outer.obj")), hollow = volume(file("both.obj"));
    CHECK(hollow < outside - 500);
    CHECK(volume(file("both.obj") + " --cavities keep") == Approx(hollow));
    CHECK(volume(file("both.obj") + " --shells cavity") == Approx(hollow));
    CHECK(volume(file("both.obj") + " --cavities fill") == Approx(outside));
    // The names of former recipes.
    CHECK(volume(file("both.obj") + " --shells solid") == Approx(outside));
    CHECK(volume(file("both.obj") + " --repair --cavities fill") == Approx(outside));
    CHECK(volume(file("outer.obj") + " --cavities inner=" + file("inner.obj")) == Approx(hollow));
    const std::string both =
        " --cavities outer=" + file("outer.obj") + ",inner=" + file("inner.obj");
    CHECK(volume(both) == Approx(hollow));
    CHECK(vdbPack("verify " + file("p.csv") + both).code == 0);
    CHECK(vdbPack("densify " + file("p.csv") + both + " -o " + file("d.csv")).code == 0);
    CHECK(vdbPack("carve " + file("p.csv") + both + " --voids threshold --delete-fraction 0.1 -o " +
                  file("c.csv"))
              .code == 0);

    const auto aside = vdbPack("pack " + file("outer.obj") +
                               " --cavities inner=" + file("aside.obj") + " -o " + file("p.csv"));
    CHECK(aside.code == 3);
    CHECK_THAT(aside.text, Contains("inner surface") && Contains("--repair"));
    CHECK(volume(file("outer.obj") + " --repair --cavities inner=" + file("aside.obj")) < outside);

    const auto garbled =
        vdbPack("pack " + file("outer.obj") + " --cavities hollow -o " + file("p.csv"));
    CHECK(garbled.code == 2);
    CHECK_THAT(garbled.text, Contains("keep, fill"));
    const auto two = vdbPack("pack " + file("both.obj") + " --cavities outer=" + file("outer.obj") +
                             ",inner=" + file("inner.obj") + " -o " + file("p.csv"));
    CHECK(two.code == 2);
    CHECK_THAT(two.text, Contains("--cavities"));
    CHECK(vdbPack("pack -o " + file("p.csv")).code == 2);
}

TEST_CASE("bones that nearly touch are packed apart with --repair-components") {
    const TemporaryFolder folder;
    const std::string mesh = folder.path() + "/spine.obj", pack = folder.path() + "/p.csv";
    // Two bodies 0.1 mm apart, each with a process that intersects it.
    TriangleMesh spine;
    for (const double x : {0.0, 10.1}) {
        spine = merged(spine, boxMesh({{x, 0, 0}}, {{x + 10, 10, 10}}));
        spine = merged(spine, boxMesh({{x + 4, 4, 4}}, {{x + 6, 6, 12}}));
    }
    writeObj(spine, mesh);
    const std::string words = mesh + " --repair --repair-voxel 0.5 ";
    const auto changesOf = [&](const std::string& more) {
        const auto report =
            jsonOf(vdbPack("pack " + words + more + " --radius constant:1 --json -o " + pack));
        CHECK(report["protrusion"]["spheres"] == 0);
        return report["domain"]["repair"]["changes"];
    };
    CHECK(changesOf("")["after"]["components"] == 1);
    const auto apart = changesOf("--repair-components separate");
    CHECK(apart["before"]["components"] == 4);
    CHECK(apart["after"]["components"] == 2);
    CHECK(apart["fusedInto"] == 2);
    const auto wrong = vdbPack("mesh " + words + "--repair-components apart");
    CHECK(wrong.code == 2);
    CHECK_THAT(wrong.text, Contains("--repair-components") && Contains("separate"));
}
