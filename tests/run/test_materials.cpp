// What spheres are made of: moduli of parts and without grey values, small spheres in coarse
// images.
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/report/run_result.h"
#include "vdbpack/run/interfaces.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace {

std::vector<double> columnIn(const RunResult& run, const char* name) {
    const Column* const column = columnOfNumbers(std::get<Pack<3>>(run.pack), name);
    REQUIRE(column);
    return column->numbers;
}

PackRecipe blockOf(const std::string& file, double from, const char* name) {
    writeStl(boxMesh({{{from, 0, 0}}, {{from + 6, 6, 6}}}), file, Unit::millimeter, "test");
    PackRecipe part = recipeFor(file, "uniform:0.5,1");
    part.name = name;
    return part;
}

}  // namespace

TEST_CASE("densities that are given stay with the pack, of all and of parts") {
    const TemporaryFolder folder;
    PackJob ball = recipeFor("ball:4", "constant:0.8");
    ball.density = "1900";
    ball.outputs = {folder.file("p.csv")};
    for (const double density : columnIn(runPack(ball), kDensityColumn)) CHECK(density == 1900);
    CHECK(columnOfNumbers(readPack(folder.file("p.csv")), kDensityColumn));
    PackRecipe recipe;
    recipe.parts = {blockOf(folder.file("a.stl"), 0, "bone"),
                    blockOf(folder.file("b.stl"), 6, "screw")};
    recipe.parts[0].density = "1800";
    recipe.parts[1].density = "4430";
    recipe.outputs = {folder.file("q.vtp")};
    const RunResult run = runPack(recipe);
    const auto densities = columnIn(run, kDensityColumn), parts = columnIn(run, kPartColumn);
    for (std::size_t i = 0; i < parts.size(); ++i)
        CHECK(densities[i] == (parts[i] == 0 ? 1800 : 4430));
    // By region: all of a pack without a shell are 0.
    for (PackRecipe& part : recipe.parts) part.density = "0=1900,1=400";
    for (const double density : columnIn(runPack(recipe), kDensityColumn)) CHECK(density == 1900);
}

TEST_CASE("a density in another unit is warned of with the number to give") {
    PackJob ball = recipeFor("ball:4", "constant:0.8");
    for (const char* density : {"4.43", "4.43e-9"}) {
        ball.density = density;
        CHECK(mentions(runPack(ball).report.warnings, "give 4430"));
    }
}

TEST_CASE("a modulus alone is a column without grey values") {
    PackJob recipe = recipeFor("ball:4", "constant:0.8");
    recipe.grey.modulus = "700";
    for (const double modulus : columnIn(runPack(recipe), kModulusColumn)) CHECK(modulus == 700);
    recipe.grey.modulus = "4730,1.56";
    CHECK_THROWS_WITH(runPack(recipe), Contains("calibration"));
}

TEST_CASE("each part has its own modulus, or the run is refused") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.parts = {blockOf(folder.file("a.stl"), 0, "bone"),
                    blockOf(folder.file("b.stl"), 6, "screw")};
    recipe.parts[1].grey.modulus = "110000";
    CHECK_THROWS_WITH(runPack(recipe), Contains("bone") && Contains("modulus"));
    recipe.parts[0].grey.modulus = "6850,1.49";
    CHECK_THROWS_WITH(runPack(recipe), Contains("bone") && Contains("calibration"));
    recipe.parts[0].grey.modulus = "900";
    const RunResult run = runPack(recipe);
    const auto moduli = columnIn(run, kModulusColumn), part = columnIn(run, kPartColumn);
    for (std::size_t i = 0; i < moduli.size(); ++i)
        CHECK(moduli[i] == (part[i] == 0 ? 900 : 110000));
    CHECK(std::count(part.begin(), part.end(), 1.0) > 50);
    // An implant in GPa shows in the report.
    REQUIRE(run.report.materials.size() == 2);
    CHECK(run.report.materials[1].part == "screw");
    CHECK(*run.report.materials[1].modulus == std::array<double, 3>{110000, 110000, 110000});
    CHECK_FALSE(run.report.materials[1].density);
    CHECK_THAT(summary(run.report), Contains("screw: Young's modulus 110,000 MPa"));
    CHECK_FALSE(mentions(run.report.warnings, "moduli are in MPa"));
    recipe.parts[1].density = "4430";
    for (const char* modulus : {"110", "110e9"}) {
        recipe.parts[1].grey.modulus = modulus;
        CHECK(mentions(runPack(recipe).report.warnings, "screw has a Young's modulus of"));
    }
    // Trabecular beside cortical bone.
    recipe.parts[1].density.clear();
    recipe.parts[1].grey.modulus = "200";
    CHECK_FALSE(mentions(runPack(recipe).report.warnings, "moduli are in MPa"));
}

TEST_CASE("the report states least, middle and largest density and modulus of the spheres") {
    Pack<3> pack;
    pack.spheres.assign(4, {{{0, 0, 0}}, 1});
    pack.columns = {{kDensityColumn, {1900, 200, 700, 900}, {}, {}}};
    const auto all = materialsOf(pack);
    REQUIRE(all.size() == 1);
    CHECK(all[0].part.empty());
    CHECK(*all[0].density == std::array<double, 3>{200, 900, 1900});
    CHECK_FALSE(all[0].modulus);
    CHECK(materialsOf(Pack<3>{}).empty());
}

TEST_CASE("spheres smaller than a voxel are named, and averaged over a length") {
    const TemporaryFolder folder;
    const std::string file = folder.file("noise.nrrd");
    // A chessboard: each voxel is off by as much as its neighbors, the other way.
    writeNrrd(file,
              Voxels<float>::of(gridAround(12, {{2, 2, 2}}),
                                [](const Vec<3>& p) {
                                    const double cell = std::floor(p[0] / 2 + 0.25) +
                                                        std::floor(p[1] / 2 + 0.25) +
                                                        std::floor(p[2] / 2 + 0.25);
                                    return std::fmod(std::fabs(cell), 2) < 0.5 ? 1000 : 1400;
                                }),
              "float");
    PackJob recipe = recipeFor("ball:5", "constant:0.5");
    recipe.grey.samples = {"hu=" + file};
    const RunResult noisy = runPack(recipe);
    CHECK(std::any_of(
        noisy.report.warnings.begin(), noisy.report.warnings.end(),
        [](const std::string& text) { return text.find("sampleLength") != std::string::npos; }));
    const auto values = columnIn(noisy, "hu");
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    CHECK(*most - *least > 350);
    recipe.grey.sampleLength = 6;
    for (const double value : columnIn(runPack(recipe), "hu"))
        CHECK(value == Approx(1200).margin(80));
    // Lengths in meters and in micrometers.
    for (const auto& [length, words] :
         {std::pair{0.006, "has no effect"}, std::pair{6000.0, "much of the pack"}}) {
        recipe.grey.sampleLength = length;
        CHECK(mentions(runPack(recipe).report.warnings, words));
    }
}

TEST_CASE("BV/TV of the solid stands beside the share that the spheres fill") {
    PackJob recipe = recipeFor("box:12,12,12", "uniform:0.4,0.8");
    setVoids(recipe.request, "boolean", "constant:1.5", 0.4);
    recipe.request.shell = 2;
    const RunResult run = runPack(settled(recipe));
    const auto& pack = std::get<Pack<3>>(run.pack);
    double filled = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        if (pack.region[i] == 1) filled += Measure<3>::ball(pack.spheres[i].radius);
    CHECK(*run.report.voids->filled == Approx(filled / (8 * 8 * 8)));
    CHECK(*run.report.voids->filled < *run.report.voids->bvtv);
}

TEST_CASE("carve refuses parts with walls that its domain does not have, and says where to ask") {
    const TemporaryFolder folder;
    writeHalves(folder.file("two.nrrd"));
    PackJob job;
    job.domain.source = folder.file("two.nrrd");
    job.domain.label = "all";
    job.targetCount = 500;
    job.outputs = {folder.file("p.vtp")};
    runPack(job);
    auto carve = onPack<CarveJob>(folder.file("p.vtp"), folder.file("two.nrrd"));
    carve.domain.label = "5";
    setVoids(carve.request, "boolean", "constant:1", 0.5);
    CHECK_THROWS_WITH(runCarve(carve), Contains("Set `voids` in the run that packs the parts"));
}

TEST_CASE("settings of a domain are refused where there is none") {
    const TemporaryFolder folder;
    runPack(recipeFor("ball:5", "uniform:0.5,1", folder.file("p.csv")));
    auto convert = onPack<ConvertRecipe>(folder.file("p.csv"), {}, folder.file("q.csv"));
    convert.domain.repair = true;
    CHECK_THROWS_WITH(runConvert(convert), Contains("`repair` applies to the domain"));
    convert.domain.repair = false;
    convert.domain.pose.translate = Vec<3>{100, 0, 0};
    CHECK_THROWS_WITH(runConvert(convert), Contains("`translate`"));
}
