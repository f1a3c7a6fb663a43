// What users try first: a folder of masks, a pack in another unit, a picture of an image.
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/text_file.h"

#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/preview/preview.h"

#include <filesystem>

namespace {

ImageGrid voxelsOfHalfMillimeter() {
    return gridAround(10, {{0.5, 0.5, 0.5}});
}

/// A mask of a ball, as a program for segmentation writes one for each bone.
void writeMask(const std::string& file, const Vec<3>& center, double radius) {
    writeNrrd(file,
              Voxels<std::uint8_t>::of(
                  voxelsOfHalfMillimeter(),
                  [&](const Vec<3>& p) { return length(p - center) < radius ? 1 : 0; }),
              "uint8");
}

}  // namespace

TEST_CASE("a folder of masks is packed as parts whose names are in every file") {
    const TemporaryFolder folder;
    const std::string masks = folder.file("masks");
    std::filesystem::create_directory(masks);
    writeMask(masks + "/vertebrae_L3.nrrd", {{0, 0, -5}}, 4);
    writeMask(masks + "/vertebrae_L4.nrrd", {{0, 0, 5}}, 4);
    writeMask(masks + "/rib.nrrd", {{0, 0, 0}}, 0);
    PackRecipe recipe;
    recipe.domain.source = masks;
    recipe.domain.label = "vertebrae_L3,vertebrae_L4";
    recipe.targetCount = 400;
    recipe.density = "1900";
    for (const char* name : {"p.vtp", "materials:m.csv", "yade:p.txt", "p.data"}) {
        const OutputTarget target(name);
        const std::string prefix(name, std::string(name).size() - target.file.size());
        recipe.outputs.push_back(prefix + folder.file(target.file));
    }
    const RunResult run = runPack(recipe);
    REQUIRE(run.report.parts.size() == 2);
    CHECK(static_cast<double>(run.report.count) == Approx(400).epsilon(0.02));
    const std::vector<std::string> names{"vertebrae_L3", "vertebrae_L4"};
    CHECK(partNames(readPack(folder.file("p.vtp"))) == names);
    for (const char* file : {"m.csv", "p.txt", "p.data"}) {
        CAPTURE(file);
        for (const std::string& name : names)
            CHECK_THAT(contentOf(folder.file(file)), Contains(name));
    }
}

TEST_CASE("a pack that falls apart is warned of, and two separate bodies are not") {
    const TemporaryFolder folder;
    const auto warningsWithNeck = [&](double neck, double hollow = 0) {
        const auto isInside = [&](const Vec<3>& p) {
            if (length(p - Vec<3>{{0, 0, 6}}) < hollow) return false;
            const Vec<3> fromAxis{{p[0], p[1], 0}};
            return length(p - Vec<3>{{0, 0, -6}}) < 4 || length(p - Vec<3>{{0, 0, 6}}) < 4 ||
                   (std::abs(p[2]) < 6 && length(fromAxis) < neck);
        };
        const std::string file = folder.file("bodies.nrrd");
        writeNrrd(file, Voxels<std::uint8_t>::of(voxelsOfHalfMillimeter(), isInside), "uint8");
        return warningsOf(recipeFor(file, "uniform:0.8,1"));
    };
    CHECK_FALSE(mentions(warningsWithNeck(0), "largest connected component"));
    CHECK_FALSE(mentions(warningsWithNeck(0, 3), "largest connected component"));
    CHECK(mentions(warningsWithNeck(0.7), "largest connected component"));
}

TEST_CASE("a pack written in another unit has its own hash when it is read back in it") {
    const TemporaryFolder folder;
    const Unit unit = GENERATE(Unit::meter, Unit::micrometer);
    PackRecipe recipe = recipeFor("ball:9", "uniform:0.8,1");
    recipe.outUnit = unit;
    for (const char* name : {"p.csv", "p.vtp", "p.npz", "p.xyz"})
        recipe.outputs.push_back(folder.file(name));
    const auto hash = runPack(recipe).report.hash;
    for (const char* name : {"p.csv", "p.vtp", "p.npz", "p.xyz"}) {
        CAPTURE(name);
        VerifyRecipe verify = onPack<VerifyRecipe>(folder.file(name), "ball:9");
        verify.packUnit = unit;
        const RunResult run = runVerify(verify);
        CHECK(run.report.hash == hash);
        CHECK(run.passed);
    }
}

TEST_CASE("an image is drawn by its labels or at a threshold without packing") {
    if (!canDrawSpace()) return;
    const TemporaryFolder folder;
    writeMask(folder.file("mask.nrrd"), {}, 6);
    ConvertRecipe convert;
    convert.pack = folder.file("mask.nrrd");
    convert.domain.threshold = 0.5;
    convert.outputs = {folder.file("ball.stl")};
    convert.preview.file = folder.file("ball.png");
    CHECK(runConvert(convert).files.size() == 2);
    CHECK(isPng(folder.file("ball.png")));
    ViewRecipe view;
    view.pack = convert.pack;
    view.reportFile = folder.file("ball.html");
    runView(view);
    CHECK_THAT(contentOf(view.reportFile), Contains("mask") && Contains("</html>"));
}

TEST_CASE("level sets whose voxels OpenVDB cannot hold in a unit are refused before the work") {
    const TemporaryFolder folder;
    auto voids = voidsIn("box:0.3,0.3,0.3", folder.file("v.vdb"));
    setVoids(voids.request, "boolean", "constant:0.05", 0.5);
    voids.request.voxelSize = 0.01;
    voids.outUnit = Unit::meter;
    const std::string message = messageOf<ParameterError>([&] { runVoids(voids); });
    CHECK_THAT(message, Contains("v.vdb: voxels of 1e-05 m") && Contains("`outUnit` to mm"));
    CHECK(std::filesystem::is_empty(folder.path()));
    voids.outUnit = Unit::micrometer;
    CHECK_NOTHROW(runVoids(voids));
    // Points have no such bound: the voxels that sort them may be larger.
    auto pack = recipeFor("ball:0.3", "uniform:0.01,0.02", folder.file("p.vdb"));
    pack.outUnit = Unit::meter;
    const Pack<3> made = std::get<Pack<3>>(runPack(pack).pack);
    const Pack<3> read = readPack(folder.file("p.vdb"));
    REQUIRE(read.spheres.size() == made.spheres.size());
    for (std::size_t i = 0; i < read.spheres.size(); ++i)
        CHECK(length(read.spheres[i].center - made.spheres[i].center) < 1e-6 * 0.01);
}

TEST_CASE("circles of a plane in a domain of space are warned of") {
    const TemporaryFolder folder;
    const std::string circles = folder.file("c.csv"), box = "box:12,12,12";
    putContent(circles, "x,y,z,radius\n0,0,1,1\n3,0,1,1\n0,3,1,1\n");
    const auto isNamed = [](const std::vector<std::string>& warnings) {
        return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
            return warning.find("lie at one height") != std::string::npos;
        });
    };
    PackJob around = recipeFor(box, "constant:1");
    around.existing = circles;
    CHECK(isNamed(runPack(around).report.warnings));
    auto densify = onPack<DensifyRecipe>(circles);
    densify.domain.source = box;
    densify.densify.fraction = 0.1;
    CHECK(isNamed(runDensify(densify).report.warnings));
    auto verify = onPack<VerifyRecipe>(circles);
    verify.domain.source = box;
    CHECK(isNamed(runVerify(verify).report.warnings));
}
