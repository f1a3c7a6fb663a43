#include "support/generators.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/test.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"

#include <nlohmann/json.hpp>

namespace {

double total(const RunResult& run) {
    return run.report.solidFractionTotal.value_or(0);
}

}  // namespace

TEST_CASE("the mesh of a ball packs like the ball, wherever it lies") {
    const TemporaryFolder folder;
    const auto ball = ballMesh(30, 5);
    const double exact = total(runPack(recipeFor("ball:30", "uniform:1,2")));
    const auto check = [&](const TriangleMesh& mesh, const char* name, Unit unit) {
        CAPTURE(name);
        const std::string file = folder.file(std::string(name) + ".obj");
        writeObj(mesh, file);
        PackRecipe recipe = recipeFor(file, "uniform:1,2");
        recipe.domain.unit = unit;
        const auto run = runPack(recipe);
        CHECK(run.passed);
        CHECK(total(run) == Approx(exact).margin(0.003));
    };
    check(ball, "plain", Unit::millimeter);
    check(uvBallMesh(30, 60, 90), "other triangles", Unit::millimeter);
    check(rotated(ball, {{1, 2, 3}}, 0.7), "turned", Unit::millimeter);
    check(translated(ball, {{1e4, -1e4, 1e4}}), "moved", Unit::millimeter);
    check(scaled(ball, 1e-3), "in meters", Unit::meter);
}

TEST_CASE("depth is the distance to the wall, however deep") {
    const TemporaryFolder folder;
    writeObj(ballMesh(20, 5), folder.file("b.obj"));
    for (const std::string& source : {folder.file("b.obj"), std::string("ball:20")}) {
        CAPTURE(source);
        PackRecipe recipe = recipeFor(source, "uniform:1,2");
        const auto run = runPack(recipe);
        const auto& pack = std::get<Pack<3>>(run.pack);
        float deepest = 0;
        for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
            CHECK(pack.depth[i] == Approx(20 - length(pack.spheres[i].center)).margin(0.03));
            deepest = std::max(deepest, pack.depth[i]);
        }
        CHECK(deepest > 15);
        recipe.domain.clips = {parseClip("plane:0,0,2,4")};  // z <= 2
        const auto cut = runPack(recipe);
        const auto& half = std::get<Pack<3>>(cut.pack);
        for (std::size_t i = 0; i < half.spheres.size(); ++i) {
            const auto& c = half.spheres[i].center;
            CHECK(half.depth[i] == Approx(std::min(20 - length(c), 2 - c[2])).margin(0.03));
        }
    }
}

TEST_CASE("a pack does not depend on how it is reported") {
    const TemporaryFolder folder;
    writeObj(ballMesh(34, 4), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:1,2");
    recipe.reportFile = folder.file("p.json");
    const auto plain = runPack(recipe);
    recipe.reportFile = folder.file("p.html");
    CHECK(runPack(recipe).report.hash == plain.report.hash);
    // Three mean diameters, though the packer needs the field to three largest radii only.
    CHECK_THAT(contentOf(folder.file("p.html")), Contains("g, error: 120 rows"));
}

TEST_CASE("what a run warns of is in its report") {
    const TemporaryFolder folder;
    writeObj(ballMesh(0.5, 3), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:0.05,0.1", folder.file("p.csv"));
    Listener listener;
    const auto packed = runPack(recipe, listener.callbacks);
    REQUIRE(listener.warnings.size() == 1);
    CHECK(listener.heard("`unit`"));
    CHECK(packed.report.warnings == listener.warnings);
    auto measure = onPack<MeasureRecipe>(recipe.outputs[0].text);
    CHECK_THAT(runMeasure(measure).run.report.warnings.at(0), Contains("`packUnit`"));
}

TEST_CASE("ids that several spheres share are warned of") {
    const TemporaryFolder folder;
    auto measure = onPack<MeasureRecipe>(folder.file("p.csv"));
    std::ofstream(measure.pack)
        << "id,x,y,z,radius\n9,0,0,0,1\n7,5,0,0,1\n7,0,5,0,1\n9,0,0,5,1\n-1,5,5,5,1\n";
    const auto warnings = runMeasure(measure).run.report.warnings;
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("5 spheres") && Contains("3 different") && Contains("7"));
}

TEST_CASE("verify names the check that failed, and no other") {
    const TemporaryFolder folder;
    Pack<3> pack;
    pack.spheres = {{{{-1, 0, 0}}, 1}, {{{1.05, 0, 0}}, 1}};
    writePack(pack, folder.file("p.csv"), PackWriteOptions{});
    auto verify = onPack<VerifyRecipe>(folder.file("p.csv"), "ball:10");
    verify.gap = GENERATE(0.01, 0.1);
    const auto run = runVerify(verify);
    CHECK(run.passed == (verify.gap < 0.05));
    CHECK(failures(run).empty() == run.passed);
    if (!run.passed) CHECK_THAT(failures(run), Catch::StartsWith("gap"));
    CHECK_FALSE(toJson(run)["overlap"].contains("worst"));
}

TEST_CASE("a slice is packed with circles and verified as circles") {
    const TemporaryFolder folder;
    writeObj(ballMesh(30, 5), folder.file("b.obj"));
    for (const std::string& source : {folder.file("b.obj"), std::string("ball:30")}) {
        CAPTURE(source);
        PackRecipe recipe = recipeFor(source, "uniform:0.5,1", folder.file("c.csv"));
        recipe.domain.slice = 10;
        const auto run = runPack(recipe);
        CHECK(run.passed);
        CHECK(run.report.volume == Approx(kPi * 800).epsilon(0.005));
        CHECK(total(run) > 0.78);
        auto verify = onPack<VerifyRecipe>(folder.file("c.csv"));
        verify.domain = recipe.domain;
        CHECK(runVerify(verify).passed);
    }
}

TEST_CASE("a clip cuts the domain and the pack") {
    PackRecipe recipe = recipeFor("ball:15", "uniform:0.8,1.6");
    recipe.domain.clips = {parseClip("plane:0,0,1,0"), parseClip("box:-20,-20,-20,20,5,20")};
    const auto run = runPack(recipe);
    CHECK(run.passed);
    for (const auto& s : std::get<Pack<3>>(run.pack).spheres) {
        CHECK(s.center[2] + s.radius <= 1e-9);
        CHECK(s.center[1] + s.radius <= 5 + 1e-9);
    }
}

TEST_CASE("a level set written by one run is the domain of another") {
    const TemporaryFolder folder;
    writeObj(ballMesh(12, 5), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:1,2", folder.file("p.vdb"));
    const auto first = runPack(recipe);
    recipe.domain.source = folder.file("p.vdb");
    recipe.outputs.clear();
    const auto second = runPack(recipe);
    CHECK(second.passed);
    CHECK(second.report.volume == Approx(first.report.volume).epsilon(0.02));
    recipe.outputs = {folder.file("p.vdb")};
    CHECK_THROWS_AS(runPack(recipe), ParameterError);  // would overwrite its input
}

TEST_CASE("an interrupted run keeps what is complete, or writes nothing") {
    const TemporaryFolder folder;
    PackRecipe recipe = recipeFor("box:150,150,150", "uniform:1,2", folder.file("p.csv"));
    Callbacks callbacks;
    bool stop = true;
    callbacks.cancelled = [&] { return stop; };
    recipe.targetCount = 100000;  // stopped in the trial packs
    auto run = runPack(recipe, callbacks);
    CHECK(run.report.interrupted);
    if (run.report.count == 0) CHECK(folder.files() == 0);
    stop = false;
    recipe.targetCount = 0;
    callbacks.progress = [&](const Progress& p) { stop = stop || p.count > 2000; };
    run = runPack(recipe, callbacks);
    CHECK(run.report.interrupted);
    CHECK(run.report.count > 2000);
    CHECK(run.passed);
    auto verify = onPack<VerifyRecipe>(folder.file("p.interrupted.csv"), recipe.domain.source);
    CHECK(runVerify(verify).passed);
}

TEST_CASE("an interrupt never replaces the files of a whole run") {
    const TemporaryFolder folder;
    PackRecipe recipe = recipeFor("box:40,40,40", "uniform:1,2");
    recipe.outputs = {folder.file("p.csv"), folder.file("p.vdb"), "yade:" + folder.file("p.txt"),
                      "contacts:" + folder.file("pairs.csv"), folder.file("plain.name/p.vtp")};
    std::filesystem::create_directory(folder.file("plain.name"));
    recipe.reportFile = folder.file("p.json");
    recipe.preview.file = folder.file("p.png");
    recipe.optionsText = "domain = \"box:40,40,40\"\n";
    const auto whole = runPack(recipe);
    std::vector<std::pair<std::string, std::string>> before;
    for (const auto& file : whole.report.files) before.emplace_back(file, contentOf(file));
    REQUIRE(before.size() == 8);
    bool stop = false;
    Callbacks callbacks;
    callbacks.cancelled = [&] { return stop; };
    callbacks.progress = [&](const Progress& p) { stop = stop || p.count > 300; };
    const auto part = runPack(recipe, callbacks);
    REQUIRE(part.report.interrupted);
    for (const auto& [file, bytes] : before) CHECK(contentOf(file) == bytes);
    REQUIRE(part.report.files.size() == 7);
    for (const auto& file : part.report.files) {
        CAPTURE(file);
        CHECK(file.find(".interrupted.") != std::string::npos);
        CHECK(std::filesystem::exists(file));
    }
    CHECK(contentOf(folder.file("p.interrupted.txt")).find(", interrupted") != std::string::npos);
}

TEST_CASE("a target count on a mesh is met within 2 percent") {
    const TemporaryFolder folder;
    writeObj(torusMesh(30, 10, 96, 48), folder.file("t.obj"));
    PackRecipe recipe = recipeFor(folder.file("t.obj"), "");
    recipe.targetCount = 8000;
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(static_cast<double>(run.report.count) == Approx(8000).epsilon(0.02));
}

TEST_CASE("a pack is added to, and what stood there is written again as it was") {
    const TemporaryFolder folder;
    const std::string file = folder.file("implant.csv");
    putContent(file,
               "x,y,z,radius,material,id,label\n"
               "0,0,0,4,7,30,screw\n0,0,5,3.5,7,31,screw\n0,0,24,3,8,40,head\n");
    PackRecipe recipe = recipeFor("ball:25", "uniform:0.8,1.6");
    recipe.existing = file;
    recipe.packing.gap = 0.05;
    recipe.outputs = {folder.file("out.csv"), folder.file("out.vdb")};
    Listener listener;
    const auto run = runPack(recipe, listener.callbacks);
    CHECK(run.passed);
    CHECK(run.report.existing == 3);
    CHECK(run.report.inputOverlaps == 1);     // the screw's two spheres
    CHECK(run.report.inputProtrusions == 1);  // the head
    REQUIRE(listener.warnings.size() == 2);
    for (const auto& warning : listener.warnings) CHECK_THAT(warning, Contains("implant.csv"));
    CHECK(run.report.overlap->pairs == 1);
    CHECK(*run.report.smallestGap >= 0.05);
    CHECK(*run.report.smallestGap < 0.0501);
    CHECK(*run.report.ks < 0.02);

    const auto pack = readPack(folder.file("out.csv"));
    REQUIRE(pack.spheres.size() == run.report.count);
    REQUIRE(pack.spheres.size() > 1000);
    CHECK(pack.spheres[1].center[2] == 5);
    CHECK(pack.spheres[1].radius == 3.5);
    REQUIRE(pack.id.size() == pack.spheres.size());
    CHECK(std::vector<std::int64_t>(pack.id.begin(), pack.id.begin() + 5) ==
          std::vector<std::int64_t>{30, 31, 40, 41, 42});
    const auto column = [&](const std::string& name) {
        return *std::find_if(pack.columns.begin(), pack.columns.end(),
                             [&](const Column& c) { return c.name == name; });
    };
    CHECK(column("material").numbers[1] == 7);
    CHECK(column("material").numbers[3] == 0);
    CHECK(column("label").texts[2] == "head");
    CHECK(column("existing").numbers[2] == 1);
    CHECK(column("existing").numbers[3] == 0);
    auto verify = onPack<VerifyRecipe>(folder.file("out.vdb"));
    CHECK(runVerify(verify).report.hash == run.report.hash);

    // In stages: what was added stands in the next one.
    recipe.existing = folder.file("out.csv");
    recipe.radius = SizeRequest::parse("uniform:0.2,0.4");
    recipe.outputs = {folder.file("more.csv")};
    const auto more = runPack(recipe);
    CHECK(more.passed);
    CHECK(more.report.existing == run.report.count);
    CHECK(more.report.count > 2 * run.report.count);
    recipe.outputs = {};
    recipe.domain.source = "rect:9,9";
    CHECK_THROWS_WITH(runPack(recipe), Contains("out.csv") && Contains("circles"));
}

TEST_CASE("a target count is met, or the run says that it is not") {
    const auto count = [](PackRecipe recipe, double target, bool& warned) {
        recipe.targetCount = target;
        Listener listener;
        const auto n = static_cast<double>(runPack(recipe, listener.callbacks).report.count);
        warned = !listener.warnings.empty();
        return n;
    };
    bool warned = false;
    for (const char* radius : {"", "constant:1", "lognormal:1,0.5,0.3,3"})
        for (const double target : {3.0, 20.0, 50.0, 400.0}) {
            CAPTURE(radius, target);
            const double n = count(recipeFor("ball:20", radius), target, warned);
            CHECK((std::fabs(n - target) <= std::max(0.5, 0.02 * target)) != warned);
            CHECK(std::fabs(n - target) < std::max(6.0, 0.05 * target));
        }
    PackRecipe recipe = recipeFor("box:20,20,20", "");
    recipe.packing.gap = 1;
    CHECK(count(recipe, 3000, warned) == Approx(3000).epsilon(0.02));
    recipe.packing.gap = 5;
    CHECK_THROWS_WITH(count(recipe, 1000, warned), Contains("gap of 5 mm"));
}

TEST_CASE("a front in a wedge settles where there is room for its spheres") {
    const TemporaryFolder folder;
    TriangleMesh wedge = boxMesh({{0, 0, -1}, {40, 20, 1}});
    for (Vec<3>& v : wedge.vertices) v[2] *= 0.8 + 1.7 * v[0] / 40;  // 1.6 to 5 mm thick
    writeStl(wedge, folder.file("wedge.stl"), Unit::millimeter, "test");
    PackJob job = recipeFor(folder.file("wedge.stl"), "uniform:1,2");
    const RunResult front = runPack(settled(job));
    job.settle = true;
    const RunResult run = runPack(settled(job));
    CHECK_FALSE(mentions(run.report.warnings, "overlaps were left"));
    CHECK(run.report.count == front.report.count);
    CHECK(run.report.hash != front.report.hash);
    CHECK(run.report.protrusion->max <= 0);
}
