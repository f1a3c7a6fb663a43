// Solids in place of packs: images, meshes and shapes to surfaces.
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/text_file.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/report/image_result.h"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace {

constexpr double kBallRadius = 6;

/// Grey values that fall with the distance from the origin: 100 at the wall of a ball, and 0 beyond
/// twice its radius.
std::string greyBall(const TemporaryFolder& folder, double halfWidth = 8) {
    const auto voxels =
        Voxels<std::int16_t>::of(gridAround(halfWidth, {{0.5, 0.5, 0.5}}), [](const Vec<3>& p) {
            return std::lround(std::max(0.0, 200 - 100 * length(p) / kBallRadius));
        });
    writeMeta(folder.file("ball.mha"), voxels, "MET_SHORT");
    return folder.file("ball.mha");
}

/// Two boxes that touch: labels 3 and 5.
std::string twoLabels(const TemporaryFolder& folder) {
    const auto voxels = Voxels<std::uint8_t>::of(gridAround(10, {{1, 1, 1}}), [](const Vec<3>& p) {
        const bool inside = std::fabs(p[0]) < 8 && std::fabs(p[1]) < 5 && std::fabs(p[2]) < 4;
        return !inside ? 0 : p[0] < 0 ? 3 : 5;
    });
    writeMeta(folder.file("two.mha"), voxels, "MET_UCHAR");
    return folder.file("two.mha");
}

ConvertRecipe converting(const std::string& from, const std::vector<std::string>& to) {
    auto recipe = onPack<ConvertRecipe>(from);
    recipe.outputs = {to.begin(), to.end()};
    return recipe;
}

double volumeOf(const std::string& file) {
    return checkMesh(readMesh(file)).signedVolume;
}

}  // namespace

TEST_CASE("the surface of an image above a threshold is converted without packing") {
    const TemporaryFolder folder;
    auto recipe = converting(greyBall(folder), {folder.file("b.stl"), folder.file("b.vdb")});
    CHECK_THROWS_WITH(runConvert(recipe), Contains("`threshold`"));
    recipe.domain.threshold = 100;
    const auto result = runConvert(recipe);
    CHECK(result.kind == "image");
    CHECK(result.found.empty());
    const double ball = 4 * kPi / 3 * std::pow(kBallRadius, 3);
    CHECK(volumeOf(folder.file("b.stl")) == Approx(ball).epsilon(0.01));
    CHECK(holdsLevelSet(folder.file("b.vdb")));
    recipe.outputs = {folder.file("c.stl")};
    recipe.packUnit = Unit::centimeter;
    runConvert(recipe);
    CHECK(volumeOf(folder.file("c.stl")) == Approx(1000 * ball).epsilon(0.01));
    CHECK_FALSE(mentions(result.warnings, "border of the image"));
}

TEST_CASE("a solid that the border of its image cuts is warned of with a threshold, too") {
    const TemporaryFolder folder;
    auto recipe = converting(greyBall(folder, 4.5), {folder.file("b.stl")});
    recipe.domain.threshold = 100;
    const ImageGrid grid = gridAround(4.5, {{0.5, 0.5, 0.5}});
    const double face = std::fabs(grid.origin[0]);
    int cut = 0;
    forEachVoxel(grid, [&](std::size_t, const Vec<3>& p) {
        const double most = std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])});
        cut += most > face - 0.1 && std::lround(200 - 100 * length(p) / kBallRadius) >= 100;
    });
    REQUIRE(cut > 100);
    const std::string said = std::to_string(cut) + " voxels on the border of the image";
    CHECK(mentions(runConvert(recipe).warnings, said));
    ImageRecipe image;
    image.domain = recipe.domain;
    image.domain.source = recipe.pack;
    CHECK(mentions(runImage(image).warnings, said));
}

TEST_CASE("a threshold by Otsu's method is reported, and as a number gives the same") {
    const TemporaryFolder folder;
    auto recipe = converting(greyBall(folder), {folder.file("b.stl")});
    recipe.domain.threshold = Threshold::otsu();
    const auto result = runConvert(recipe);
    REQUIRE(result.found.size() == 1);
    CHECK(result.found[0].option == "threshold");
    CHECK(result.found[0].word == "otsu");
    recipe.domain.threshold = std::stod(result.found[0].value);
    recipe.outputs = {folder.file("again.stl")};
    runConvert(recipe);
    CHECK(readMesh(folder.file("again.stl")).vertices == readMesh(folder.file("b.stl")).vertices);

    ImageRecipe seen;
    seen.domain.source = recipe.pack;
    const ImageResult image = runImage(seen);
    REQUIRE(image.taken.size() == 1);
    CHECK(*image.taken[0].threshold.value == std::stod(result.found[0].value));
    const auto json = toJson(image);
    std::size_t sum = 0;
    for (const auto& count : json["histogram"]["counts"]) sum += count.get<std::size_t>();
    CHECK(sum == image.grid.voxels());
    CHECK(json["thresholds"][0]["threshold"] == "otsu");
    CHECK_THAT(summary(image), Contains("values from") && Contains("otsu"));

    VoidsJob job = voidsIn(recipe.pack, folder.file("v.vdb"));
    job.domain.threshold = Threshold::otsu();
    job.optionsText = "[voids]\nthreshold = 'otsu'\nseed = 1\n";
    setVoids(job.request, "boolean", "constant:1.5", 0.7);
    CHECK_THAT(runVoids(job).report.recipe,
               Contains("\nthreshold = " + result.found[0].value + "  # otsu\nseed"));
}

TEST_CASE("an image that names no sides of a patient is given none") {
    const TemporaryFolder folder;
    writeNrrd(folder.file("i.nrrd"),
              Voxels<std::uint8_t>::of(gridAround(5, {{1, 1, 1}}),
                                       [](const Vec<3>& p) { return length(p) < 4; }),
              "uint8");
    ImageRecipe recipe;
    recipe.domain.source = folder.file("i.nrrd");
    CHECK(toJson(runImage(recipe))["orientation"] == "LPS");
    std::string bytes = contentOf(recipe.domain.source);
    const std::string space = "space: left-posterior-superior";
    bytes.replace(bytes.find(space), space.size(), "space dimension: 3");
    writeBytes(recipe.domain.source, bytes);
    const ImageResult image = runImage(recipe);
    CHECK(mentions(image.warnings, "which side is left"));
    CHECK(toJson(image)["orientation"].is_null());
    CHECK_THAT(summary(image), !Contains("LPS"));
}

TEST_CASE("several labels become one surface file, or one for each") {
    const TemporaryFolder folder;
    auto recipe = converting(twoLabels(folder), {folder.file("all.stl"), folder.file("{part}.stl"),
                                                 folder.file("{part}.vdb")});
    recipe.domain.label = "all";
    const auto result = runConvert(recipe);
    CHECK(result.files == std::vector<std::string>{folder.file("all.stl"), folder.file("3.stl"),
                                                   folder.file("5.stl"), folder.file("3.vdb"),
                                                   folder.file("5.vdb")});
    const double one = volumeOf(folder.file("3.stl")), other = volumeOf(folder.file("5.stl"));
    CHECK(one == Approx(8 * 10 * 8).epsilon(0.1));
    CHECK(volumeOf(folder.file("all.stl")) == Approx(one + other));
    recipe.outputs = {folder.file("all.vdb")};
    CHECK_THROWS_WITH(runConvert(recipe), Contains("all.vdb") && Contains("{part}"));
    recipe.domain.label = "3+5";
    runConvert(recipe);
    CHECK(holdsLevelSet(folder.file("all.vdb")));
    recipe.outputs = {folder.file("x.csv")};
    CHECK_THROWS_WITH(runConvert(recipe), Contains("x.csv") && Contains("spheres"));
}

TEST_CASE("shapes, clips and repaired meshes are converted as domains are") {
    const TemporaryFolder folder;
    CHECK(runConvert(converting("box:2,4,6", {folder.file("box.stl")})).kind == "shape");
    const auto box = readMesh(folder.file("box.stl"));
    CHECK(box.triangles.size() == 12);
    CHECK(volumeOf(folder.file("box.stl")) == Approx(48));
    auto recipe = converting(folder.file("box.stl"), {folder.file("half.stl")});
    recipe.domain.clips = {parseClip("plane:0,0,1,-2")};
    runConvert(recipe);
    CHECK(volumeOf(folder.file("half.stl")) == Approx(8).epsilon(0.02));
    CHECK(readMesh(folder.file("half.stl")).bounds().hi[2] == Approx(-2).epsilon(0.01));

    // A box without one of its triangles.
    TriangleMesh open = box;
    open.triangles.pop_back();
    writeStl(open, folder.file("open.stl"));
    recipe = converting(folder.file("open.stl"), {folder.file("closed.stl")});
    recipe.domain.repair = true;
    recipe.domain.scale = 10;  // the file states mm
    runConvert(recipe);
    CHECK(volumeOf(folder.file("closed.stl")) == Approx(48000).epsilon(0.01));
    recipe.domain.unit = Unit::centimeter;
    recipe.packUnit = Unit::meter;
    CHECK_THROWS_WITH(runConvert(recipe), Contains("`packUnit`"));
    recipe = converting("rect:3,3", {folder.file("r.stl")});
    CHECK_THROWS_WITH(runConvert(recipe), Contains("is plane"));
    recipe = converting("box:2,4,6", {folder.file("r.stl")});
    recipe.domain.source = "ball:3";
    CHECK_THROWS_WITH(runConvert(recipe), Contains("`domain` ball:3"));
}

TEST_CASE("voids along the long axis of a domain say which it is, and repeat by it") {
    const TemporaryFolder folder;
    const double angle = 0.5;
    TriangleMesh bar = boxMesh({{{-10, -3, -4}}, {{10, 3, 4}}});
    for (Vec<3>& v : bar.vertices)
        v = {{std::cos(angle) * v[0] - std::sin(angle) * v[1],
              std::sin(angle) * v[0] + std::cos(angle) * v[1], v[2]}};
    writeStl(bar, folder.file("bar.stl"));
    struct Case {
        std::string domain, clip, axis;
    };
    for (const Case& c :
         {Case{folder.file("bar.stl"), "", "0.877583,0.479426,0"}, Case{"box:9,30,10", "", "0,1,0"},
          Case{"cylinder:5,30", "", "0,0,1"}, Case{"rect:9,20", "", "0,1"},
          Case{"box:40,30,10", "box:0,-15,-5,6,15,5", "0,1,0"}}) {
        CAPTURE(c.domain);
        VoidsJob job = voidsIn(c.domain);
        setVoids(job.request, "boolean", "constant:1", 0.8);
        if (!c.clip.empty()) job.domain.clips = {parseClip(c.clip)};
        job.request.orientation.axis = VoidAxis::parse("long");
        const RunResult run = runVoids(job);
        REQUIRE(run.report.found.size() == 1);
        CHECK(run.report.found[0].value == c.axis);
        job.request.orientation.axis = VoidAxis::parse(c.axis);
        const RunResult again = runVoids(job);
        std::visit(
            [&](const auto& list) {
                using List = std::decay_t<decltype(list)>;
                const auto& other = std::get<List>(again.voids);
                REQUIRE(list.size() == other.size());
                CHECK(list.front().center == other.front().center);
                CHECK(list.front().axis == other.front().axis);
            },
            run.voids);
    }
    VoidsJob ball = voidsIn("ball:6");
    setVoids(ball.request, "boolean", "constant:1", 0.8);
    ball.request.orientation.axis = VoidAxis::parse("long");
    CHECK_THROWS_WITH(runVoids(ball), Contains("ball:6") && Contains("long axis"));
    PackJob pack = recipeFor("box:9,30,10", "constant:0.7");
    setVoids(pack.request, "boolean", "constant:1", 0.8);
    pack.request.orientation.axis = VoidAxis::parse("long");
    const RunResult packed = runPack(pack);
    REQUIRE(packed.report.found.size() == 1);
    CHECK(toJson(packed)["found"][0]["value"] == nlohmann::ordered_json({0, 1, 0}));
}
