// What the next person learns from a run, its page and its files.
#include "support/generators.h"
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/text_file.h"
#include "support/tool.h"

#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/preview/result_picture.h"

namespace {

/// Two labels of an image as parts.
PackJob halvesIn(const std::string& file) {
    writeHalves(file);
    PackJob job;
    job.domain.source = file;
    job.domain.label = "all";
    job.targetCount = 500;
    return job;
}

PackRecipe partOf(const std::string& file, const TriangleMesh& mesh, const char* name) {
    writeStl(mesh, file, Unit::millimeter, "test");
    PackRecipe part = recipeFor(file, "uniform:0.5,1");
    part.name = name;
    return part;
}

}  // namespace

TEST_CASE("fewer pairs are listed than a pack was made with: a warning names its tolerance") {
    const TemporaryFolder folder;
    auto job = recipeFor("box:8,8,8", "uniform:0.5,1", folder.file("p.vtp"));
    job.contactTolerance = 0.05;
    runPack(job);
    auto convert = onPack<ConvertRecipe>(folder.file("p.vtp"), {}, "bonds:" + folder.file("b.csv"));
    CHECK(mentions(runConvert(convert).warnings, "`contactTolerance` 0.05"));
    convert.contactTolerance = 0.05;
    CHECK(runConvert(convert).warnings.empty());
    convert.contactTolerance = 0.1;
    CHECK(runConvert(convert).warnings.empty());
}

TEST_CASE("a page of voids is about voids") {
    const TemporaryFolder folder;
    const std::string page = folder.file("v.html");
    REQUIRE(vdbPack("voids box:6,6,6 --voids boolean --void-radius constant:1 --target-bvtv 0.6 "
                    "--preview-size 160 -o " +
                    folder.file("v.vdb") + " --report " + page)
                .code == 0);
    const std::string text = contentOf(page);
    CHECK_THAT(text, Contains("box:6,6,6, cut by voids") && Contains("BV/TV"));
    for (const char* wrong : {"There are no spheres", "0000000000000000", "a pack of"})
        CHECK_THAT(text, !Contains(wrong));
}

TEST_CASE("a page of parts compares each with what was requested, and says what it leaves out") {
    const TemporaryFolder folder;
    auto job = halvesIn(folder.file("halves.nrrd"));
    job.reportFile = folder.file("p.html");
    const RunResult run = runPack(job);
    for (const PartReport& part : run.report.parts) CHECK(part.ks.value() < 0.2);
    const std::string text = contentOf(job.reportFile);
    CHECK_THAT(text, Contains("Of all parts") && Contains("Parts have walls of their own"));
    CHECK_THAT(text, !Contains("No size distribution"));
    // The radii are those of all parts, not of the first.
    REQUIRE(mentions(run.report.chosen, "are in all parts"));
    CHECK_FALSE(mentions(run.report.chosen, "fill the domain"));
}

TEST_CASE("verify names the order in which the parts of a pack lie") {
    const TemporaryFolder folder;
    auto job = halvesIn(folder.file("halves.nrrd"));
    job.outputs = {folder.file("p.vtp")};
    const auto packed = runPack(job).report.parts;
    REQUIRE(packed.size() == 2);
    auto verify = onPack<VerifyRecipe>(folder.file("p.vtp"), job.domain.source);
    verify.domain.label = "all";
    CHECK(runVerify(verify).passed);
    verify.domain.label = packed[1].name + "," + packed[0].name;
    CHECK_THROWS_WITH(runVerify(verify), Contains(packed[0].name + ", " + packed[1].name));
}

TEST_CASE("flaws of a mesh are those of its own part") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    auto flawed = boxMesh({{-2, -2, -2}}, {{2, 2, 2}});
    flawed.triangles.push_back(flawed.triangles.front());
    recipe.parts = {partOf(folder.file("o.stl"), boxMesh({{-4, -4, -4}}, {{4, 4, 4}}), "outer"),
                    partOf(folder.file("i.stl"), flawed, "inner")};
    const auto warnings = runPack(recipe).report.warnings;
    CHECK(mentions(warnings, "inner: " + folder.file("i.stl") + ": the mesh has flaws"));
    CHECK_FALSE(mentions(warnings, "outer: "));
}

TEST_CASE("bonds that no output lists are warned of") {
    const TemporaryFolder folder;
    auto job = recipeFor("box:6,6,6", "constant:0.7", folder.file("p.csv"));
    job.bonds.law.breakingStrain = 0.01;
    CHECK(mentions(runPack(job).report.warnings, "no output lists them"));
    auto convert =
        onPack<ConvertRecipe>(folder.file("p.csv"), {}, "contacts:" + folder.file("c.csv"));
    convert.bonds.classes = 3;
    CHECK(mentions(runConvert(convert).warnings, "no output lists them"));
    job.outputs.emplace_back("bonds:" + folder.file("b.csv"));
    CHECK_FALSE(mentions(runPack(job).report.warnings, "no output lists them"));
}

TEST_CASE("measure warns of another body's domain") {
    const TemporaryFolder folder;
    runPack(recipeFor("box:6,6,6", "constant:0.7", folder.file("p.csv")));
    const auto measured =
        runMeasure(onPack<MeasureRecipe>(folder.file("p.csv"), "box:30,30,30,40,40,40"));
    CHECK(mentions(measured.run.report.warnings, "another body's domain"));
}

TEST_CASE("warnings of a study name their run") {
    const TemporaryFolder folder;
    const auto run = vdbPack(
        "pack box:6,6,6 --radius constant:0.5 --voids boolean --void-radius constant:0.8 "
        "--target-bvtv 0.1 --seed 5,6 -o " +
        folder.file("p_{seed}.csv"));
    CHECK_THAT(run.text, Contains("warning: seed 5: ") && Contains("warning: seed 6: "));
}

TEST_CASE("the sides of a picture are those of the axes that a pack states") {
    const PreviewOptions plain = inWorldOf(PackOrigin{}, {}),
                         ras = inWorldOf(PackOrigin{"RAS"}, {});
    CHECK_FALSE(plain.ofPatient);
    CHECK(ras.ofPatient);
    CHECK(ras.space == ImageSpace::ras);
}
