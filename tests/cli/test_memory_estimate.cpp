// What runs give and take, estimated before: spheres, memory, disk space.
#include "support/generators.h"
#include "support/jobs.h"
#include "support/limited_tool.h"
#include "support/mesh_file.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/core/clock.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/run/estimate.h"

#include <nlohmann/json.hpp>

namespace {

#ifdef VDBPACK_SANITIZED
constexpr bool kSanitized = true;  // whose tables are most of the memory
#else
constexpr bool kSanitized = false;
#endif

/// The memory estimated where less is allowed, though as much as reading takes, and that of the
/// run.
std::pair<double, double> estimatedAndTaken(const std::string& line, unsigned seconds) {
    std::vector<std::string> words = wordsOf(line + " --threads 2 --quiet --json");
    const auto run = vdbPackWithin(seconds, words);
    CAPTURE(run.text);
    REQUIRE(run.code == 0);
    words.insert(words.end(), {"--memory-limit", "76M"});
    const auto refused = vdbPackWithin(seconds, words);
    CAPTURE(refused.text);
    REQUIRE(refused.code == 5);
    const std::string start = "would take about ";
    std::istringstream estimated(refused.text.substr(refused.text.find(start) + start.size()));
    std::string number, unit;
    estimated >> number >> unit;
    const auto report = nlohmann::json::parse(run.text.substr(run.text.find('{')));
    return {parseBytes(number + unit).value(), report["peakMemoryBytes"].get<double>()};
}

}  // namespace

TEST_CASE("a dry run comes true within its errors, and writes nothing") {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("b.obj"), out = folder.file("p.csv");
    writeObj(ballMesh(12, 4), mesh);
    // The larger sphere lies outside.
    std::ofstream(folder.file("others.csv")) << "x,y,z,radius\n0,0,0,10\n0,0,300,50\n";
    const std::string box = "box:30,30,30 ", beside = " --existing " + folder.file("others.csv");
    const std::string boolean = " --voids boolean --target-bvtv 0.4 --void-radius constant:3";
    const std::vector<std::string> packs{
        box + "--radius constant:0.8",
        box + "--radius uniform:0.5,1",
        box + "--radius uniform:1,2",
        box + "--radius uniform:0.5,1 --gap 0.1",
        box + "--radius uniform:0.5,1 --effort fast",
        box + "--radius lognormal:0.6,0.4,0.3,1.5",
        box + "--target-count 3000 --gap 0.2",
        box + "--radius uniform:0.5,1 --max-count 500",
        box + "--radius uniform:0.5,1" + beside,
        box + "--target-count 4000" + beside,
        "box:5,50,50 --radius uniform:0.5,1 --densify 0.6",
        box + "--radius uniform:0.7,1.4 --densify 0.8",
        box + "--target-count 3000 --densify 0.63",
        "rect:100,50 --radius uniform:0.3,0.6",
        "rect:100,100 --radius constant:0.5",
        mesh + " --radius uniform:0.4,0.8",
        mesh + " --target-count 5000",
        mesh + " --slice z=2 --radius uniform:0.1,0.2",
        mesh + " --clip plane:1,0,0,0 --radius uniform:0.4,0.8",
        box + "--radius uniform:0.5,1" + boolean,
        box + "--radius uniform:0.5,1 --shell 2" + boolean,
        box + "--target-count 4000" + boolean,
        box + "--radius uniform:0.5,1 --voids concentric --delete-fraction 0.3"};
    for (const std::string& pack : packs) {
        CAPTURE(pack);
        const std::string line = "pack " + pack + " --quiet --json -o " + out;
        const auto dry = vdbPackWithin(20, wordsOf(line + " --dry-run"));
        REQUIRE(dry.code == 0);
        REQUIRE_FALSE(std::filesystem::exists(out));
        const auto run = vdbPackWithin(60, wordsOf(line));
        CAPTURE(dry.text, run.text);
        REQUIRE(run.code == 0);
        std::filesystem::remove(out);
        const auto expected = nlohmann::json::parse(dry.text);
        const auto report = nlohmann::json::parse(run.text.substr(run.text.find('{')));
        const double error = expected["errors"]["count"];
        const auto near = [&](const nlohmann::json& value) {
            return Approx(value.get<double>()).epsilon(error);
        };
        CHECK(expected["spheres"]["count"].get<double>() == near(report["spheres"]["count"]));
        CHECK(expected["solidFraction"]["total"].get<double>() ==
              near(report["solidFraction"]["total"]));
        CHECK(expected["seconds"]["pack"] > 0);
    }
}

TEST_CASE("a dry run refuses what a run does, and says what densifying cannot reach") {
    PackRecipe recipe = recipeFor("box:40,40,40", "uniform:1,2");
    recipe.densify.fraction = 0.8;
    CHECK_FALSE(dryRunPack(recipe).densified);
    recipe.densify.fraction = 0.64;
    CHECK(dryRunPack(recipe).densified);
    recipe.outputs = {"/none/pack.csv"};
    CHECK_THROWS_AS(dryRunPack(recipe), IoError);
    recipe.outputs = {};
    recipe.radius = SizeRequest::parse("uniform:30,40");
    CHECK_THROWS_AS(dryRunPack(recipe), InputError);
    // A plate that lies askew is thinner than the box around it.
    const TemporaryFolder folder;
    writeObj(rotated(boxMesh({{-10, -10, -0.5}}, {{10, 10, 0.5}}), {{1, 0, 0}}, 0.8),
             folder.file("plate.obj"));
    PackJob plate = recipeFor(folder.file("plate.obj"), "uniform:0.1,0.2");
    plate.request.shell = 0.3;
    CHECK_NOTHROW(dryRunPack(settled(plate)));
    plate.request.shell = 2;
    CHECK_THAT(messageOf<InputError>([&] { dryRunPack(settled(plate)); }),
               Contains("`shell` 2 mm") && Contains("deepest"));
}

TEST_CASE("a dry run of a thin plate expects no radii that do not fit") {
    PackRecipe recipe = recipeFor("box:40,40,1", "uniform:0.36,0.72");
    CHECK(dryRunPack(recipe).count ==
          Approx(static_cast<double>(runPack(recipe).report.count)).epsilon(0.1));
    recipe.targetCount = 500;
    std::vector<std::string> warnings;
    const DryRun expected = dryRunPack(recipe, keepingWarnings({}, warnings));
    CHECK(expected.count == Approx(static_cast<double>(runPack(recipe).report.count)).epsilon(0.1));
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings.front(), Contains("0.5 mm fits"));
    recipe.targetCount = 50;
    CHECK_THROWS_AS(dryRunPack(recipe), InputError);
    CHECK_THROWS_AS(runPack(recipe), InputError);
}

TEST_CASE("a dry run of parts predicts them together") {
    PackRecipe recipe = recipeFor("", "uniform:0.5,1");
    recipe.targetCount = 3000;
    PackRecipe inner = recipeFor("ball:6", "uniform:0.5,1"),
               outer = recipeFor("box:-10,-10,-10,-7,10,10", "");
    inner.name = "inner";
    outer.name = "outer";
    inner.targetCount = outer.targetCount = recipe.targetCount;
    outer.radius = inner.radius;
    recipe.parts = {outer, inner};
    const DryRun expected = dryRunPack(recipe);
    CHECK(expected.count == Approx(3000).epsilon(0.05));
    CHECK(expected.volume == Approx(3 * 400 + Measure<3>::ball(6)).epsilon(0.02));
    const RunResult run = runPack(recipe);
    CHECK(expected.solidFraction == Approx(*run.report.solidFractionTotal).epsilon(0.05));
}

TEST_CASE("a clip leaves the volume that is reported") {
    const TemporaryFolder folder;
    writeObj(ballMesh(12, 4), folder.file("b.obj"));
    DomainRecipe recipe;
    recipe.source = folder.file("b.obj");
    const auto whole = DomainSource(recipe).left();
    recipe.clips = {parseClip("plane:1,0,0,0")};
    const auto half = DomainSource(recipe).left();
    CHECK(half.volume == Approx(whole.volume / 2).epsilon(0.02));
    // Half of the sphere, and the disc between the halves.
    CHECK(half.area == Approx(0.75 * whole.area).epsilon(0.02));
    recipe.clips = {parseClip("plane:1,1,0,0"), parseClip("plane:0,0,-1,0")};
    CHECK(DomainSource(recipe).left().volume == Approx(whole.volume / 4).epsilon(0.04));
    recipe.clips = {parseClip("plane:1,0,0,-50")};
    CHECK_THROWS_AS(DomainSource(recipe).left().volume, InputError);
    recipe.clips.clear();
    recipe.slice = 7.2;  // a disc of radius 9.6
    const double circle = 2 * std::acos(-1.0) * 9.6;
    CHECK(DomainSource(recipe).left().volume == Approx(circle * 4.8).epsilon(0.03));
    CHECK(DomainSource(recipe).left().area == Approx(circle).epsilon(0.02));
    recipe.clips = {parseClip("plane:1,0,0,0")};
    CHECK(DomainSource(recipe).left().volume == Approx(circle * 2.4).epsilon(0.03));
    CHECK(DomainSource(recipe).left().area == Approx(circle / 2 + 19.2).epsilon(0.04));
}

TEST_CASE("a request beyond all memory is refused at once with its parts") {
    const TemporaryFolder folder;
    const std::string ball = folder.file("b.obj");
    writeObj(ballMesh(12, 4), ball);
    struct Case {
        std::string line;
        const char* part;
        const char* remedy;
    };
    const Case cases[] = {
        {"pack ball:10 --target-count 1e12", "e+12 spheres", "--target-count or --max-count"},
        {"pack " + ball + " --target-count 1e12", "e+12 spheres", "larger radii"},
        {"pack " + ball + " --radius constant:1e-5", "spheres", "larger radii"},
        {"pack rect:100,100 --radius constant:1e-5", "circles", "larger radii"},
        {"pack " + ball + " --slice z=0 --radius constant:1e-7", "circles", "larger radii"},
        {"pack " + ball + " --radius constant:1 --voxel 0.001", "voxels of 0.001 mm",
         "larger --voxel"},
        {"voids " + ball +
             " --voids boolean --void-radius constant:1 --void-voxel 1e-4 "
             "--void-count 10",
         "voids in voxels of 0.0001 mm", "larger --void-voxel"},
        {"voids ball:10 --voids boolean --target-bvtv 0.5 --void-radius constant:0.001", "voids",
         "larger voids"},
        {"voids ball:10 --voids overlay --void-radius constant:0.001", "voids", "larger voids"},
        {"voids ball:10 --voids grid --void-cell 0.02", "voids", "larger voids"},
        {"measure " + ball + " --voxel 0.001", "image of about", "larger --voxel"},
        {"convert " + ball + " -o " + folder.file("b.vdb") + " --voxel 0.0005", "voxels of 0.0005",
         "larger --voxel"}};
    for (const Case& c : cases) {
        CAPTURE(c.line);
        const auto run = vdbPackWithin(10, wordsOf(c.line + " --json"));
        CHECK(run.code == 5);
        CHECK_THAT(run.text, Contains("would take about") && Contains("may be taken") &&
                                 Contains(c.part) && Contains(c.remedy));
        CHECK(run.peakBytes < (kSanitized ? 2e9 : 2e8));
    }
    CHECK_FALSE(std::filesystem::exists(folder.file("b.vdb")));
}

TEST_CASE("a limit of memory is kept by every command") {
    const TemporaryFolder folder;
    const std::string pack = folder.file("p.csv");
    REQUIRE(vdbPackWithin(20, {"pack", "ball:9", "--radius", "constant:1", "-o", pack}).code == 0);
    for (const std::string line :
         {"pack ball:9 --radius constant:1", "pack rect:9,9 --radius constant:1",
          "voids ball:9 --voids boolean --void-radius constant:1"}) {
        CAPTURE(line);
        CHECK(vdbPackWithin(10, wordsOf(line + " --json --memory-limit 2M")).code == 5);
    }
    for (const std::string& line :
         {"verify " + pack, "verify " + pack + " --domain ball:9", "measure " + pack,
          "convert " + pack + " -o " + folder.file("q.vtp"),
          "carve " + pack + " --domain ball:9 --voids boolean"}) {
        CAPTURE(line);
        const auto run = vdbPackWithin(10, wordsOf(line + " --json --memory-limit 2M"));
        CHECK(run.code == 5);
        CHECK_THAT(run.text, Contains("2 MiB may be taken") || Contains("2 MiB are allowed"));
    }
    CHECK_FALSE(std::filesystem::exists(folder.file("q.vtp")));
    for (const char* bad : {"0", "-1", "much", "nan", "8X", ""}) {
        CAPTURE(bad);
        const auto run = vdbPackWithin(10, {"pack", "ball:9", "--memory-limit", bad});
        CHECK(run.code == 2);
        CHECK_THAT(run.text, Contains("--memory-limit"));
    }
}

TEST_CASE("a dry run reports memory and files, also of runs that are refused") {
    const TemporaryFolder folder;
    const std::string line = "pack box:30,30,30 --radius uniform:0.5,1 --dry-run -o " +
                             folder.file("p.csv") + " -o " + folder.file("p.vtp");
    const auto text = vdbPackWithin(20, wordsOf(line));
    CHECK(text.code == 0);
    CHECK_THAT(text.text, Contains("memory     about") && Contains("p.vtp about"));
    const auto json = nlohmann::json::parse(vdbPackWithin(20, wordsOf(line + " --json")).text);
    const auto& memory = json["memory"];
    CHECK(json["peakMemoryBytes"] >= memory["spheres"]);
    CHECK(memory["program"] > 1e6);
    REQUIRE(json["files"].size() == 2);
    CHECK(json["files"][1]["name"] == folder.file("p.vtp"));
    const auto much = vdbPackWithin(20, wordsOf(line + " --memory-limit 10M"));
    CHECK(much.code == 5);
    CHECK_THAT(much.text, Contains("dry run") && Contains("10 MiB may be taken"));
    const auto voids = nlohmann::json::parse(
        vdbPackWithin(60, wordsOf(line + " --json --voids boolean --void-radius constant:1")).text);
    CHECK(voids["memory"]["voids"] > 1e6);
}

TEST_CASE("files are about as large as estimated") {
    const TemporaryFolder folder;
    writeObj(ballMesh(12, 4), folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:0.4,0.8");
    for (const char* name :
         {"p.vdb", "p.csv", "p.vtp", "p.vtkhdf", "p.ply", "p.xyz", "p.npz", "p.data"})
        recipe.outputs.push_back(folder.file(name));
    recipe.outputs.push_back("yade:" + folder.file("p.txt"));
    recipe.outputs.push_back("contacts:" + folder.file("c.csv"));
    recipe.outputs.push_back("surface:" + folder.file("s.stl"));
    const Estimate estimated = dryRunPack(recipe).estimate;
    const auto run = runPack(recipe);
    REQUIRE(run.report.files.size() >= recipe.outputs.size());
    REQUIRE(estimated.files.size() == recipe.outputs.size());
    for (std::size_t i = 0; i < recipe.outputs.size(); ++i) {
        CAPTURE(recipe.outputs[i].text);
        const auto bytes = static_cast<double>(std::filesystem::file_size(run.report.files[i]));
        CHECK(estimated.files[i].bytes > 0.7 * bytes);
        CHECK(estimated.files[i].bytes < 2 * bytes);
    }
}

TEST_CASE("files for which a disk has no room are refused with both figures") {
    Estimate estimated;
    estimated.files = {{"/tmp/a.csv", 1e6}, {"yade:/tmp/p.txt", 1e19}};
    CHECK_THROWS_AS(requireResources(estimated, 1e12), ResourceError);
    CHECK_THROWS_WITH(
        requireResources(estimated, 1e12),
        Contains("yade:/tmp/p.txt: would take about 9.09e+06 TiB") && Contains("are free there"));
    estimated.files.pop_back();
    CHECK_NOTHROW(requireResources(estimated, 1e12));
}

TEST_CASE("estimated memory is memory taken", "[.slow]") {
    if (kSanitized) return;
    const TemporaryFolder folder;
    writeObj(ballMesh(30, 6), folder.file("b.obj"));
    const std::string ball = folder.file("b.obj");
    for (const std::string& line :
         {std::string("pack box:100,100,100 --radius constant:0.5"),
          "pack box:60,60,60 --radius constant:0.3 -o contacts:" + folder.file("c.csv"),
          "pack " + ball + " --radius uniform:0.3,0.6", "pack " + ball + " --target-count 5e5",
          "pack " + ball + " --radius constant:2 --voxel 0.1",
          std::string("pack box:100,100,100 --radius uniform:0.4,0.8 --densify 0.64"),
          "pack " + ball + " --radius uniform:0.4,0.8 --densify 0.64",
          "pack ball:20 --radius uniform:1,2 -o " + folder.file("s.stl"),
          "pack ball:20 --radius uniform:1,2 -o levelsets:" + folder.file("l.vdb"),
          std::string("voids box:60,60,60 --voids boolean --target-bvtv 0.3 --void-radius "
                      "constant:1 --void-voxel 0.15"),
          std::string("voids box:12,12,12 --voids foam --target-bvtv 0.1 --void-radius "
                      "uniform:0.3,0.5 --void-voxel 0.05"),
          "voids box:8,8,8 --voids foam --target-bvtv 0.1 --void-radius uniform:0.3,0.5 "
          "--void-voxel 0.05 --preview " +
              folder.file("p.png"),
          "pack " + ball +
              " --radius uniform:1,2 --voids boolean --target-bvtv 0.4 --void-radius constant:3 "
              "--void-voxel 0.3 --measure-solid",
          std::string("voids box:5,5,5 --target-bvtv 0.2 --target-tbsp 0.8 --void-voxel 0.022")}) {
        CAPTURE(line);
        const auto [estimated, taken] = estimatedAndTaken(line, 200);
        CHECK(estimated > 0.8 * taken);
        CHECK(estimated < (line.find("--target-tbsp") == std::string::npos ? 1.5 : 1.7) * taken);
    }
}

TEST_CASE("the voids of an estimate are about those of the run") {
    for (const auto& [domain, method, shell] :
         std::vector<std::tuple<std::string, std::string, double>>{{"box:12,12,12", "foam", 0},
                                                                   {"box:20,20,20", "foam", 2},
                                                                   {"box:20,20,20", "foam", 0},
                                                                   {"ball:12", "boolean", 0},
                                                                   {"ball:12", "boolean", 2}}) {
        CAPTURE(domain, method, shell);
        auto recipe = recipeFor(domain, "uniform:0.5,1");
        setVoids(recipe.request, method, "", 0.4);
        recipe.request.shell = shell;
        const double expected =
            planPack(settled(recipe), DomainSource(recipe.domain)).extent.voids.count;
        CHECK(expected ==
              Approx(static_cast<double>(runPack(recipe).report.voids->count)).epsilon(0.25));
    }
}

TEST_CASE("an estimate of a clipped mesh ends before its field is made") {
    const TemporaryFolder folder;
    TriangleMesh open = ballMesh(30, 6);
    open.triangles.pop_back();
    writeObj(open, folder.file("b.obj"));
    PackRecipe recipe = recipeFor(folder.file("b.obj"), "uniform:0.08,0.16");
    recipe.domain.clips = {parseClip("plane:1,0,0,0")};
    const Clock clock;
    CHECK(dryRunPack(recipe).count > 1e6);
    if (!kSanitized) CHECK(clock.total() < 5);
    recipe.memoryLimit = 1e8;  // refused, so that a closer look is needless
    const Clock refused;
    dryRunPack(recipe);
    if (!kSanitized) CHECK(refused.total() < 1);
}
