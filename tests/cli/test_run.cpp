#include "cli/recipes.h"
#include "support/generators.h"
#include "support/mesh_file.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

using namespace vdbpack;
using namespace vdbpack::test;
using test::recipeFor;

namespace {

double total(const RunResult& run) {
    return run.report.solidFractionTotal.value_or(0);
}

std::size_t filesIn(const std::string& folder) {
    std::size_t n = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) n += entry.exists();
    return n;
}

}  // namespace

TEST_CASE("the mesh of a ball packs like the ball, wherever it lies", "[run]") {
    const TemporaryFolder folder;
    const auto ball = test::ballMesh(30, 5);
    const double exact = total(runPack(recipeFor("ball:30", "uniform:1,2")));
    const auto check = [&](const TriangleMesh& mesh, const char* name, Unit unit) {
        CAPTURE(name);
        const std::string file = folder.file(std::string(name) + ".obj");
        test::writeObj(mesh, file);
        PackRecipe recipe = recipeFor(file, "uniform:1,2");
        recipe.domain.unit = unit;
        const auto run = runPack(recipe);
        CHECK(run.passed);
        CHECK(total(run) == Approx(exact).margin(0.003));
    };
    check(ball, "plain", Unit::millimeter);
    check(test::uvBallMesh(30, 60, 90), "other triangles", Unit::millimeter);
    check(test::rotated(ball, {{1, 2, 3}}, 0.7), "turned", Unit::millimeter);
    check(test::translated(ball, {{1e4, -1e4, 1e4}}), "moved", Unit::millimeter);
    check(test::scaled(ball, 1e-3), "in meters", Unit::meter);
}

TEST_CASE("depth is the distance to the wall, however deep", "[run]") {
    const TemporaryFolder folder;
    test::writeObj(test::ballMesh(20, 5), folder.file("b.obj"));
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

TEST_CASE("a marrow cavity stays empty, whichever way its triangles face", "[run]") {
    const TemporaryFolder folder;
    const auto inner = test::ballMesh(5, 4);
    const bool inverted = GENERATE(true, false);
    CAPTURE(inverted);
    const auto mesh = test::merged(test::ballMesh(10, 4), inverted ? test::flipped(inner) : inner);
    test::writeObj(mesh, folder.file("hollow.obj"));
    const auto run = runPack(recipeFor(folder.file("hollow.obj"), "uniform:0.5,1"));
    CHECK(run.passed);
    CHECK(run.report.volume == Approx(3665).epsilon(0.01));
    for (const auto& s : std::get<Pack<3>>(run.pack).spheres) CHECK(length(s.center) > 5);
}

TEST_CASE("verify passes what pack wrote, in every format, with the same hash", "[run]") {
    const TemporaryFolder folder;
    test::writeObj(test::translated(test::ballMesh(12, 4), {{730, -50, 3}}), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:1,2");
    for (const char* name : {"p.vdb", "p.csv", "p.vtp"})
        recipe.outputs.push_back(folder.file(name));
    recipe.reportFile = folder.file("p.json");
    const auto packed = runPack(recipe);
    REQUIRE(packed.passed);
    CHECK(packed.report.overlap->max == 0);
    CHECK(packed.report.protrusion->max == 0);
    for (const auto& file : recipe.outputs) {
        CAPTURE(file.text);
        VerifyRecipe verify;
        verify.pack = file.text;
        verify.domain.source = folder.file("b.obj");
        verify.radius = SizeRequest::parse("uniform:1,2");
        const auto run = runVerify(verify);
        CHECK(run.passed);
        CHECK(run.report.hash == packed.report.hash);
        CHECK(run.report.count == packed.report.count);
        CHECK(run.report.ks.value() == Approx(packed.report.ks.value()));
    }
    CHECK(filesIn(folder.path()) == 5);
}

TEST_CASE("a pack does not depend on how it is reported", "[run][report]") {
    const TemporaryFolder folder;
    test::writeObj(test::ballMesh(34, 4), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:1,2");
    recipe.reportFile = folder.file("p.json");
    const auto plain = runPack(recipe);
    recipe.reportFile = folder.file("p.html");
    CHECK(runPack(recipe).report.hash == plain.report.hash);
    std::ifstream file(folder.file("p.html"));
    std::stringstream page;
    page << file.rdbuf();
    // Three mean diameters, though the packer needs the field to three largest radii only.
    CHECK_THAT(page.str(), Catch::Contains("g, error: 120 rows"));
}

TEST_CASE("what a run warns of is in its report", "[run][report]") {
    const TemporaryFolder folder;
    test::writeObj(test::ballMesh(0.5, 3), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:0.05,0.1");
    recipe.outputs = {folder.file("p.csv")};
    std::vector<std::string> warned;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warned.push_back(text); };
    const auto packed = runPack(recipe, callbacks);
    REQUIRE(warned.size() == 1);
    CHECK_THAT(warned[0], Catch::Contains("`unit`"));
    CHECK(packed.report.warnings == warned);
    MeasureRecipe measure;
    measure.pack = recipe.outputs[0].text;
    CHECK_THAT(runMeasure(measure).run.report.warnings.at(0), Catch::Contains("`packUnit`"));
}

TEST_CASE("ids that several spheres share are warned of", "[run]") {
    const TemporaryFolder folder;
    MeasureRecipe measure;
    measure.pack = folder.file("p.csv");
    std::ofstream(measure.pack)
        << "id,x,y,z,radius\n9,0,0,0,1\n7,5,0,0,1\n7,0,5,0,1\n9,0,0,5,1\n-1,5,5,5,1\n";
    const auto warnings = runMeasure(measure).run.report.warnings;
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Catch::Contains("5 spheres") && Catch::Contains("3 different") &&
                                Catch::Contains("7"));
}

TEST_CASE("verify fails and names the sphere that was tampered with", "[run]") {
    const TemporaryFolder folder;
    const auto packed = runPack(recipeFor("ball:10", "uniform:1,2"));
    Pack<3> pack = std::get<Pack<3>>(packed.pack);
    const std::size_t victim = pack.spheres.size() / 2;
    const int damage = GENERATE(0, 1, 2);
    CAPTURE(damage);
    auto& s = pack.spheres[victim];
    if (damage == 0) {
        // Towards the sphere nearest to it.
        std::size_t nearest = victim ? 0 : 1;
        for (std::size_t i = 0; i < pack.spheres.size(); ++i)
            if (i != victim && gap(s, pack.spheres[i]) < gap(s, pack.spheres[nearest])) nearest = i;
        s.center += normalized(pack.spheres[nearest].center - s.center) * (0.1 * s.radius);
    } else if (damage == 1) {
        s.radius *= 2;
    } else {
        s.center = {{10.5, 0, 0}};
    }
    writePack(pack, folder.file("p.csv"), PackWriteOptions{});
    VerifyRecipe verify;
    verify.pack = folder.file("p.csv");
    verify.domain.source = "ball:10";
    const auto run = runVerify(verify);
    CHECK_FALSE(run.passed);
    CHECK_THAT(failures(run), Catch::Contains(std::to_string(victim)));
}

TEST_CASE("verify names the check that failed, and no other", "[run]") {
    const TemporaryFolder folder;
    Pack<3> pack;
    pack.spheres = {{{{-1, 0, 0}}, 1}, {{{1.05, 0, 0}}, 1}};
    writePack(pack, folder.file("p.csv"), PackWriteOptions{});
    VerifyRecipe verify;
    verify.pack = folder.file("p.csv");
    verify.domain.source = "ball:10";
    verify.gap = GENERATE(0.01, 0.1);
    const auto run = runVerify(verify);
    CHECK(run.passed == (verify.gap < 0.05));
    CHECK(failures(run).empty() == run.passed);
    if (!run.passed) CHECK_THAT(failures(run), Catch::StartsWith("gap"));
    CHECK_FALSE(toJson(run)["overlap"].contains("worst"));
}

TEST_CASE("a slice is packed with circles and verified as circles", "[run]") {
    const TemporaryFolder folder;
    test::writeObj(test::ballMesh(30, 5), folder.file("b.obj"));
    for (const std::string& source : {folder.file("b.obj"), std::string("ball:30")}) {
        CAPTURE(source);
        PackRecipe recipe = recipeFor(source, "uniform:0.5,1");
        recipe.domain.slice = 10;
        recipe.outputs = {folder.file("c.csv")};
        const auto run = runPack(recipe);
        CHECK(run.passed);
        CHECK(run.report.volume == Approx(kPi * 800).epsilon(0.005));
        CHECK(total(run) > 0.78);
        VerifyRecipe verify;
        verify.pack = folder.file("c.csv");
        verify.domain = recipe.domain;
        CHECK(runVerify(verify).passed);
    }
}

TEST_CASE("a clip cuts the domain and the pack", "[run]") {
    PackRecipe recipe = recipeFor("ball:15", "uniform:0.8,1.6");
    recipe.domain.clips = {parseClip("plane:0,0,1,0"), parseClip("box:-20,-20,-20,20,5,20")};
    const auto run = runPack(recipe);
    CHECK(run.passed);
    for (const auto& s : std::get<Pack<3>>(run.pack).spheres) {
        CHECK(s.center[2] + s.radius <= 1e-9);
        CHECK(s.center[1] + s.radius <= 5 + 1e-9);
    }
}

TEST_CASE("a level set written by one run is the domain of another", "[run]") {
    const TemporaryFolder folder;
    test::writeObj(test::ballMesh(12, 5), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:1,2");
    recipe.outputs = {folder.file("p.vdb")};
    const auto first = runPack(recipe);
    recipe.domain.source = folder.file("p.vdb");
    recipe.outputs.clear();
    const auto second = runPack(recipe);
    CHECK(second.passed);
    CHECK(second.report.volume == Approx(first.report.volume).epsilon(0.02));
    recipe.outputs = {folder.file("p.vdb")};
    CHECK_THROWS_AS(runPack(recipe), ParameterError);  // would overwrite its input
}

TEST_CASE("bad input is refused with its kind of error and leaves no file", "[run]") {
    const TemporaryFolder folder;
    const std::string out = folder.file("o.csv");
    const auto refuse = [&](PackRecipe recipe, auto check) {
        if (recipe.outputs.empty()) recipe.outputs = {out};
        check(recipe);
        CHECK_FALSE(std::filesystem::exists(out));
    };
    const auto input = [](const PackRecipe& r) { CHECK_THROWS_AS(runPack(r), InputError); };
    const auto parameter = [](const PackRecipe& r) { CHECK_THROWS_AS(runPack(r), ParameterError); };
    const auto io = [](const PackRecipe& r) { CHECK_THROWS_AS(runPack(r), IoError); };

    refuse(recipeFor(folder.file("none.stl"), ""), io);
    refuse(recipeFor("bone.xyz", ""), input);
    std::ofstream(folder.file("empty.obj")) << "";
    refuse(recipeFor(folder.file("empty.obj"), ""), input);
    std::ofstream(folder.file("nan.obj")) << "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    refuse(recipeFor(folder.file("nan.obj"), ""), input);
    auto open = test::ballMesh(10, 3);
    open.triangles.resize(open.triangles.size() / 2);
    test::writeObj(open, folder.file("open.obj"));
    refuse(recipeFor(folder.file("open.obj"), "uniform:0.5,1"), [](const PackRecipe& r) {
        CHECK_THROWS_WITH(runPack(r), Catch::Contains("open.obj") && Catch::Contains("vertex"));
    });
    refuse(recipeFor("ball:3", "uniform:4,5"),
           [](const PackRecipe& r) { CHECK_THROWS_WITH(runPack(r), Catch::Contains("radius")); });
    refuse(recipeFor("ball:10", "uniform:1e-9,1"), parameter);
    refuse(recipeFor("ball:-1", "uniform:1,2"), parameter);
    refuse(recipeFor("box:1,2", "uniform:1,2"), parameter);
    auto clipped = recipeFor("ball:10", "uniform:1,2");
    clipped.domain.clips = {parseClip("plane:0,0,1,-20")};
    refuse(clipped, input);
    auto missing = recipeFor("ball:10", "uniform:1,2");
    missing.outputs = {folder.file("no/such/folder/o.csv")};
    refuse(missing, io);
    auto unknown = recipeFor("ball:10", "uniform:1,2");
    unknown.outputs = {folder.file("o.docx")};
    refuse(unknown, parameter);
    auto picture = recipeFor("ball:10", "uniform:1,2");
    picture.outputs = {out, folder.file("o.svg")};
    refuse(picture, parameter);
    auto twice = recipeFor("ball:10", "uniform:1,2");
    twice.outputs = {out, out};
    refuse(twice, parameter);
}

TEST_CASE("an interrupted run keeps what is complete, or writes nothing", "[run]") {
    const TemporaryFolder folder;
    PackRecipe recipe = recipeFor("box:150,150,150", "uniform:1,2");
    recipe.outputs = {folder.file("p.csv")};
    Callbacks callbacks;
    bool stop = true;
    callbacks.cancelled = [&] { return stop; };
    recipe.targetCount = 100000;  // stopped in the trial packs
    auto run = runPack(recipe, callbacks);
    CHECK(run.report.interrupted);
    if (run.report.count == 0) CHECK(filesIn(folder.path()) == 0);
    stop = false;
    recipe.targetCount = 0;
    callbacks.progress = [&](const Progress& p) { stop = stop || p.count > 2000; };
    run = runPack(recipe, callbacks);
    CHECK(run.report.interrupted);
    CHECK(run.report.count > 2000);
    CHECK(run.passed);
    VerifyRecipe verify;
    verify.pack = folder.file("p.interrupted.csv");
    verify.domain.source = recipe.domain.source;
    CHECK(runVerify(verify).passed);
}

TEST_CASE("an interrupt never replaces the files of a whole run", "[run]") {
    const TemporaryFolder folder;
    PackRecipe recipe = recipeFor("box:60,60,60", "uniform:1,2");
    recipe.outputs = {folder.file("p.csv"), folder.file("p.vdb"), "yade:" + folder.file("p.txt"),
                      "contacts:" + folder.file("pairs.csv"), folder.file("plain.name/p.vtp")};
    std::filesystem::create_directory(folder.file("plain.name"));
    recipe.reportFile = folder.file("p.json");
    recipe.preview.file = folder.file("p.png");
    recipe.optionsText = "domain = \"box:60,60,60\"\n";
    const auto whole = runPack(recipe);
    std::vector<std::pair<std::string, std::string>> before;
    for (const auto& file : whole.report.files) before.emplace_back(file, contentOf(file));
    REQUIRE(before.size() == 8);
    bool stop = false;
    Callbacks callbacks;
    callbacks.cancelled = [&] { return stop; };
    callbacks.progress = [&](const Progress& p) { stop = stop || p.count > 1000; };
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

TEST_CASE("a target count on a mesh is met within 2 percent", "[run]") {
    const TemporaryFolder folder;
    test::writeObj(test::torusMesh(30, 10, 96, 48), folder.file("t.obj"));
    PackRecipe recipe = recipeFor(folder.file("t.obj"), "");
    recipe.targetCount = 8000;
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(static_cast<double>(run.report.count) == Approx(8000).epsilon(0.02));
}

TEST_CASE("a pack is added to, and what stood there is written again as it was", "[run]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("implant.csv");
    {
        std::ofstream out(file);
        out << "x,y,z,radius,material,id,label\n"
               "0,0,0,4,7,30,screw\n0,0,5,3.5,7,31,screw\n0,0,24,3,8,40,head\n";
    }
    PackRecipe recipe = recipeFor("ball:25", "uniform:0.8,1.6");
    recipe.existing = file;
    recipe.packing.gap = 0.05;
    recipe.outputs = {folder.file("out.csv"), folder.file("out.vdb")};
    std::vector<std::string> warnings;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    const auto run = runPack(recipe, callbacks);
    CHECK(run.passed);
    CHECK(run.report.existing == 3);
    CHECK(run.report.inputOverlaps == 1);     // the screw's two spheres
    CHECK(run.report.inputProtrusions == 1);  // the head
    REQUIRE(warnings.size() == 2);
    for (const auto& warning : warnings) CHECK_THAT(warning, Catch::Contains("implant.csv"));
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
        for (const auto& c : pack.columns)
            if (c.name == name) return c;
        FAIL("no column " << name);
        return Column{};
    };
    CHECK(column("material").numbers[1] == 7);
    CHECK(column("material").numbers[3] == 0);
    CHECK(column("label").texts[2] == "head");
    CHECK(column("existing").numbers[2] == 1);
    CHECK(column("existing").numbers[3] == 0);
    VerifyRecipe verify;
    verify.pack = folder.file("out.vdb");
    CHECK(runVerify(verify).report.hash == run.report.hash);

    // In stages: what was added stands in the next one.
    recipe.existing = folder.file("out.csv");
    recipe.radius = SizeRequest::parse("uniform:0.2,0.4");
    recipe.outputs = {folder.file("more.csv")};
    const auto more = runPack(recipe);
    CHECK(more.passed);
    CHECK(more.report.existing == run.report.count);
    CHECK(more.report.count > 2 * run.report.count);
    recipe.outputs = {recipe.existing};
    CHECK_THROWS_AS(runPack(recipe), ParameterError);
    recipe.outputs = {};
    recipe.domain.source = "rect:9,9";
    CHECK_THROWS_WITH(runPack(recipe), Catch::Contains("out.csv") && Catch::Contains("circles"));
    recipe.existing = folder.file("none.csv");
    CHECK_THROWS_AS(runPack(recipe), IoError);
}

TEST_CASE("a target count is met, or the run says that it is not", "[run]") {
    const auto count = [](PackRecipe recipe, double target, bool& warned) {
        recipe.targetCount = target;
        Callbacks callbacks;
        warned = false;
        callbacks.warning = [&](const std::string&) { warned = true; };
        return static_cast<double>(runPack(recipe, callbacks).report.count);
    };
    bool warned = false;
    for (const char* radius : {"", "constant:1", "lognormal:1,0.5,0.3,3"})
        for (const double target : {3.0, 20.0, 50.0, 400.0, 3000.0}) {
            CAPTURE(radius, target);
            const double n = count(recipeFor("ball:20", radius), target, warned);
            CHECK((std::fabs(n - target) <= std::max(0.5, 0.02 * target)) != warned);
            CHECK(std::fabs(n - target) < std::max(6.0, 0.05 * target));
        }
    PackRecipe recipe = recipeFor("box:20,20,20", "");
    recipe.packing.gap = 1;
    CHECK(count(recipe, 3000, warned) == Approx(3000).epsilon(0.02));
    recipe.packing.gap = 5;
    CHECK_THROWS_WITH(count(recipe, 1000, warned), Catch::Contains("gap of 5 mm"));
}
