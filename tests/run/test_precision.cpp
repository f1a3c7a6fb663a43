// Packs far from the origin and in other units are as good as those about it.
#include "support/generators.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/paths.h"
#include "support/test.h"

#include "vdbpack/mesh/formats/mesh_io.h"

namespace {

struct Moved {
    double scale, far;
    Unit unit;
};
const Moved kMoved[] = {{1, 0, Unit::millimeter},   {1, 1e4, Unit::millimeter},
                        {1, 1e6, Unit::millimeter}, {1e-3, 0, Unit::meter},
                        {1e3, 0, Unit::micrometer}, {1e-3, 1e4, Unit::meter}};

/// Packs `mesh` moved and in other units; each must reach the same and pass after it was read.
void checkMoved(const TriangleMesh& mesh, const std::string& radius, double target,
                double tolerance) {
    const TemporaryFolder folder;
    double first = 0;
    for (const Moved& moved : kMoved) {
        CAPTURE(moved.scale, moved.far);
        TriangleMesh there = mesh;
        for (auto& v : there.vertices)
            for (double& c : v.c) c = (c + moved.far) * moved.scale;
        const std::string file = folder.file("m.obj");
        writeObj(there, file);
        PackRecipe recipe = recipeFor(file, radius);
        recipe.targetCount = target;
        recipe.domain.unit = moved.unit;
        for (const char* name :
             {"p.vdb", "p.csv", "p.vtp", "q.pvtp", "p.vtkhdf", "p.npz", "p.ply", "p.xyz", "p.data"})
            recipe.outputs.push_back(folder.file(name));
        recipe.outputs.push_back("yade:" + folder.file("p.txt"));
        const auto run = runPack(recipe);
        REQUIRE(run.passed);
        const double total = run.report.solidFractionTotal.value();
        if (first == 0) first = total;
        CHECK(total == Approx(first).margin(tolerance));
        for (const auto& output : recipe.outputs) {
            CAPTURE(output.text);
            auto verify = onPack<VerifyRecipe>(output.text);
            verify.domain = recipe.domain;
            const auto checked = runVerify(verify);
            CHECK(checked.passed);
            CHECK(checked.report.overlap->max == 0);
            CHECK(checked.report.protrusion->max == 0);
            CHECK(checked.report.hash == run.report.hash);
        }
    }
}

}  // namespace

TEST_CASE("a ball packs as well far away and in meters or micrometers") {
    checkMoved(ballMesh(10, 3), "uniform:0.8,1.6", 0, 0.015);
}

TEST_CASE("a mandible packs as well far away and in meters or micrometers", "[.slow]") {
    const auto mesh = readMesh(kMeshes + "/mandible.ply");
    checkMoved(mesh, "", 30000, 0.003);
}
