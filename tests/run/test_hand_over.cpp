// What the next person learns from a run, its page and its files.
#include "formats/lattice_pack.h"
#include "support/generators.h"
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/text_file.h"
#include "support/tool.h"

#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/preview/result_picture.h"

#include <filesystem>
#include <fstream>

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

/// Two spheres in two parts, with a gap of 0.3 of their radius.
Pack<3> pairOfParts() {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}, {{{2.3, 0, 0}}, 1}};
    pack.columns = {{kPartColumn, {0, 1}, {}, {}}};
    setPartNames(pack, {"femur", "implant"});
    return pack;
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
    CHECK(runConvert(convert).modulus == 1000);
    convert.contactTolerance = 0.05;
    CHECK(runConvert(convert).warnings.empty());
    convert.contactTolerance = 0.1;
    CHECK(runConvert(convert).warnings.empty());
}

TEST_CASE("parts and regions come back from what simulations read, or are said to be lost") {
    const TemporaryFolder folder;
    Pack<3> pack = latticePack<3>(40, {{0, 0, 0}}, 30, 2);
    pack.region.resize(40);
    Column part{kPartColumn, {}, {}, {}}, density{kClassColumn, {}, {}, {}};
    for (std::size_t i = 0; i < 40; ++i) {
        pack.region[i] = i % 2 == 0;
        part.numbers.push_back(i < 15 ? 0 : 1);
        density.numbers.push_back(static_cast<double>(i % 3));
    }
    pack.columns = {part};
    setPartNames(pack, {"femur", "implant"});
    PackWriteOptions options;
    options.generator = generatorWith("a program", {"LPS", 0.02, 0.5});
    for (const std::string file : {"data", "yade"}) {
        CAPTURE(file);
        const std::string path = (file == "yade" ? "yade:" : "") + folder.file("p." + file);
        pack.columns = {part};
        setPartNames(pack, {"femur", "implant"});
        writePack(pack, path, options);
        const auto read = readPack(path);
        CHECK(read.region == pack.region);
        REQUIRE(columnOfNumbers(read, kPartColumn) != nullptr);
        CHECK(columnOfNumbers(read, kPartColumn)->numbers == part.numbers);
        CHECK(partNames(read) == partNames(pack));
        CHECK(read.origin.interfaceTolerance == 0.5);
        pack.columns = {part, density};
        writePack(pack, path, options);
        Listener listener;
        PackReadOptions heard;
        heard.callbacks = listener.callbacks;
        CHECK(columnOfNumbers(readPack(path, heard), kPartColumn) == nullptr);
        CHECK(listener.heard("density class"));
    }
}

TEST_CASE("a domain in other axes than those of its spheres is refused with the remedy") {
    const TemporaryFolder folder;
    auto job = halvesIn(folder.file("halves.nrrd"));
    job.domain.label = "5";
    job.domain.space = ImageSpace::ras;
    job.outputs = {folder.file("p.vtp")};
    runPack(job);
    const std::string pack = folder.file("p.vtp");
    const auto on = [&](auto recipe) {
        recipe.domain.label = "5";
        return recipe;
    };
    const auto remedy = Contains("`space` ras");
    CHECK_THROWS_WITH(runMeasure(on(onPack<MeasureRecipe>(pack, job.domain.source))), remedy);
    CHECK_THROWS_WITH(runVerify(on(onPack<VerifyRecipe>(pack, job.domain.source))), remedy);
    CHECK_THROWS_WITH(
        runConvert(on(onPack<ConvertRecipe>(pack, job.domain.source, folder.file("q.data")))),
        remedy);
    auto parts = onPack<VerifyRecipe>(pack, job.domain.source);
    parts.domain.label = "5,9";
    CHECK_THROWS_WITH(runVerify(parts), remedy);
    auto carve = on(onPack<CarveJob>(pack, job.domain.source, folder.file("c.data")));
    setVoids(carve.request, "boolean", "constant:2", 0.7);
    CHECK_THROWS_WITH(runCarve(carve), remedy);
    CHECK_THROWS_WITH(runStiffness(on(onPack<StiffnessRecipe>(pack, job.domain.source))), remedy);
    auto view = on(onPack<ViewRecipe>(pack, job.domain.source));
    view.reportFile = folder.file("v.html");
    CHECK_THROWS_WITH(runView(view), remedy);
    auto around = job;
    around.domain.space = ImageSpace::lps;
    around.existing = pack;
    around.outputs = {folder.file("around.vtp")};
    CHECK_THROWS_WITH(runPack(around), remedy);
    CHECK(runMeasure(onPack<MeasureRecipe>(pack)).run.report.axes == "RAS");
}

TEST_CASE("a carved pack keeps the tolerance between its parts, and says which pairs it loses") {
    const TemporaryFolder folder;
    auto pack = latticePack<3>(300, {{0, 0, 0}}, 30, 3);
    PackWriteOptions options;
    options.generator = generatorWith("a program", {"", 0.1, 0.5});
    writePack(pack, folder.file("p.vtp"), options);
    auto carve =
        onPack<CarveJob>(folder.file("p.vtp"), "box:-20,-20,-20,40,40,40", folder.file("c.vtp"));
    setVoids(carve.request, "boolean", "constant:2", 0.9);
    const auto warnings = runCarve(carve).report.warnings;
    CHECK(mentions(warnings, "`contactTolerance` 0.1"));
    CHECK_FALSE(mentions(warnings, "`interfaceTolerance`"));
    CHECK(readPack(folder.file("c.vtp")).origin.interfaceTolerance == 0.5);
}

TEST_CASE("carve lists the pairs between parts up to the tolerance that the pack states") {
    const TemporaryFolder folder;
    Pack<3> pack = pairOfParts();
    PackWriteOptions options;
    options.generator = generatorWith("a program", {"", 0, 0.5});
    writePack(pack, folder.file("p.vtp"), options);
    auto carve = onPack<CarveJob>(folder.file("p.vtp"), "box:-5,-5,-5,8,5,5",
                                  "contacts:" + folder.file("c.csv"));
    carve.request.shell = 1;
    runCarve(carve);
    CHECK_THAT(contentOf(folder.file("c.csv")), Contains("\n0,1,"));
    writePack(pack, folder.file("p.vtp"));
    runCarve(carve);
    CHECK_THAT(contentOf(folder.file("c.csv")), !Contains("\n0,1,"));
}

TEST_CASE("coefficients of bonds of one class are refused before anything is packed") {
    const TemporaryFolder folder;
    auto job = recipeFor("box:6,6,6", "constant:0.7", folder.file("p.vtp"));
    job.outputs.emplace_back("bond-coeffs:" + folder.file("b.lmp"));
    CHECK_THROWS_WITH(runPack(job), Contains("`bondClasses`"));
    CHECK(contentOf(folder.file("p.vtp")).empty());
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
    REQUIRE(mentions(run.report.chosen, "in all parts"));
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
    CHECK(mentions(measured.run.report.warnings, "domain of another body"));
}

TEST_CASE("a folder that is not there is missing, and no format") {
    CHECK_THROWS_WITH(runPack(recipeFor("/no-folder/", "constant:1")), Contains("No such file"));
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

TEST_CASE("parts that were packed by labels are measured as one and verified one by one") {
    const TemporaryFolder folder;
    auto job = halvesIn(folder.file("halves.nrrd"));
    job.domain.label = "5,9";
    job.outputs = {folder.file("p.vtp")};
    runPack(job);
    auto measure = onPack<MeasureRecipe>(folder.file("p.vtp"), job.domain.source);
    measure.domain.label = "5,9";
    CHECK_THROWS_WITH(runMeasure(measure), Contains("join them by +"));
    measure.domain.label = "5+9";
    CHECK(runMeasure(measure).run.report.count > 0);
    auto verify = onPack<VerifyRecipe>(folder.file("p.vtp"), job.domain.source);
    verify.domain.label = "5+9";
    const RunResult joined = runVerify(verify);
    CHECK_FALSE(joined.passed);
    CHECK(mentions(joined.report.warnings, "`label` 5,9"));
    verify.domain.label = "5,9";
    const RunResult apart = runVerify(verify);
    CHECK(apart.passed);
    CHECK(apart.report.warnings.empty());
}

TEST_CASE("verify of parts names those of the pack beside other ones") {
    const TemporaryFolder folder;
    Pack<3> pack = pairOfParts();
    writePack(pack, folder.file("p.vtp"));
    auto verify = onPack<VerifyRecipe>(folder.file("p.vtp"));
    const auto box = [](double from) { return boxMesh({{from, -2, -2}}, {{from + 4, 2, 2}}); };
    verify.parts = {partOf(folder.file("a.stl"), box(20), "nail"),
                    partOf(folder.file("b.stl"), box(30), "implant")};
    const RunResult other = runVerify(verify);
    CHECK_FALSE(other.passed);
    CHECK(
        mentions(other.report.warnings, "are femur, implant, and were held against nail, implant"));
}

TEST_CASE("options that a pack leaves without effect are warned of") {
    const TemporaryFolder folder;
    Pack<3> pack = latticePack<3>(40, {{0, 0, 0}}, 30, 2);
    pack.columns = {{kModulusColumn, std::vector<double>(40, 500), {}, {}}};
    writePack(pack, folder.file("p.vtp"));
    auto convert = onPack<ConvertRecipe>(folder.file("p.vtp"), {}, "bonds:" + folder.file("b.csv"));
    CHECK(runConvert(convert).warnings.empty());
    convert.bonds.interfaceTolerance = 0.5;
    convert.bonds.law.modulus = 5;
    convert.packUnit = Unit::centimeter;
    convert.outputs.emplace_back(folder.file("p.data"));
    convert.density = "0=1900,7=1100";
    const auto warnings = runConvert(convert).warnings;
    CHECK(mentions(warnings, "`interfaceTolerance` 0.5 has no effect"));
    CHECK(mentions(warnings, "`bond-modulus` 5 has no effect"));
    CHECK(mentions(warnings, "`packUnit` cm is not used"));
    CHECK(mentions(warnings, "`density` of region 7 has no effect"));
    auto job = recipeFor("box:6,6,6", "constant:0.7", folder.file("q.csv"));
    job.bonds.interfaceTolerance = 0.5;
    CHECK(mentions(runPack(job).report.warnings, "`interfaceTolerance` 0.5 has no effect"));
}

TEST_CASE("columns that a .ply does not hold are named, and types that name no materials") {
    const TemporaryFolder folder;
    Pack<3> pack = pairOfParts();
    writePack(pack, folder.file("p.csv"));
    CHECK(mentions(
        runConvert(onPack<ConvertRecipe>(folder.file("p.csv"), {}, folder.file("p.ply"))).warnings,
        "columns 'part'"));
    pack.columns = {{"type", {2, 5}, {}, {}}};
    writePack(pack, folder.file("t.csv"));
    const std::string yade = folder.file("t.yade");
    auto convert = onPack<ConvertRecipe>(folder.file("t.csv"), {}, "yade:" + yade);
    CHECK(mentions(runConvert(convert).warnings, "`columns` density_class=type"));
    convert.packColumns.renamed = {{"density_class", "type"}};
    CHECK(runConvert(convert).warnings.empty());
    for (const std::string prefix : {"spherepack:", "yade:", "liggghts:"}) {
        convert.outputs = {prefix + folder.file("u")};
        CHECK(mentions(runConvert(convert).warnings, "columns 'density_class'") ==
              (prefix[0] == 's'));
    }
    CHECK_THAT(contentOf(yade), Contains("matId") && Contains("1.0\t0\n") && Contains("1.0\t1\n"));
}

TEST_CASE("a recipe of another command names its command") {
    const TemporaryFolder folder;
    const std::string recipe = folder.file("r.toml");
    std::ofstream(recipe) << "[carve]\nPACK = 'p.vtp'\nshell = 2\n";
    const auto refused = vdbPack("pack --config " + recipe);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.text, Contains("[carve]") && Contains("vdb_pack carve --config"));
}

TEST_CASE("a parts file that is missing comes back from the recipe of its pack") {
    const TemporaryFolder folder;
    const std::string parts = folder.file("parts.toml"), recipe = folder.file("p.recipe.toml");
    std::ofstream(parts) << "[[part]]\nname = 'a'\ndomain = 'ball:4'\n";
    REQUIRE(
        vdbPack("pack --radius constant:1 --parts " + parts + " -o " + folder.file("p.csv")).code ==
        0);
    const std::string text = contentOf(parts);
    std::filesystem::remove(parts);
    const auto refused = vdbPack("pack --config " + recipe);
    CHECK(refused.code != 0);
    const auto command = refused.text.find("sed ");
    REQUIRE(command != std::string::npos);
    REQUIRE(shell(refused.text.substr(command)).code == 0);
    CHECK(contentOf(parts) == text);
    CHECK(vdbPack("pack --config " + recipe).code == 0);
}

TEST_CASE("a part that lies apart is said to be connected by no bond") {
    const TemporaryFolder folder;
    Pack<3> pack = pairOfParts();
    pack.spheres[1].center[0] = 40;
    writePack(pack, folder.file("p.vtp"));
    const auto warnings =
        runConvert(onPack<ConvertRecipe>(folder.file("p.vtp"), {}, "bonds:" + folder.file("b.csv")))
            .warnings;
    CHECK(mentions(warnings, "femur has no bond that connects it to another part"));
    CHECK_FALSE(mentions(warnings, "next to nothing"));
}

TEST_CASE("densify refuses parts with walls that its domain does not have, and says where to ask") {
    const TemporaryFolder folder;
    PackJob job = halvesIn(folder.file("two.nrrd"));
    job.outputs = {folder.file("p.vtp")};
    runPack(job);
    auto densify = onPack<DensifyRecipe>(folder.file("p.vtp"), folder.file("two.nrrd"));
    densify.domain.label = "5";
    densify.densify.fraction = 0.63;
    CHECK_THROWS_WITH(runDensify(densify), Contains("protrude from the domain") &&
                                               Contains("in the run that packs the parts"));
}

TEST_CASE("what is lost or has no effect is said: names in a .csv, repair settings") {
    const TemporaryFolder folder;
    writePack(pairOfParts(), folder.file("p.vtp"), {});
    const auto convert = onPack<ConvertRecipe>(folder.file("p.vtp"), {}, folder.file("p.csv"));
    CHECK(mentions(runConvert(convert).warnings, "names of the parts (femur, implant)"));
    auto job = recipeFor(folder.file("b.stl"), "uniform:1,2");
    writeStl(ballMesh(8, 3), folder.file("b.stl"), Unit::millimeter, "test");
    job.domain.repairVoxel = 0.5;
    CHECK(mentions(runPack(job).report.warnings, "no effect without `repair`"));
}

TEST_CASE("verify does not pass a pack in meters as one in mm") {
    const TemporaryFolder folder;
    auto job = recipeFor("ball:40", "constant:4", folder.file("p.csv"));
    job.outUnit = Unit::meter;
    runPack(job);
    auto verify = onPack<VerifyRecipe>(folder.file("p.csv"), "ball:40");
    CHECK_THROWS_WITH(runVerify(verify), Contains("`packUnit` m"));
    verify.packUnit = Unit::meter;
    CHECK(runVerify(verify).passed);
}
