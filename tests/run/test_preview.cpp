#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"

#include <iterator>

namespace {

PackJob drawn(const std::string& domain, const std::string& file) {
    PackJob recipe = recipeFor(domain, "uniform:1,2");
    recipe.preview.file = file;
    recipe.preview.width = 160;
    recipe.preview.height = 120;
    return recipe;
}

}  // namespace

TEST_CASE("packs of space and of the plane are drawn and listed") {
    const auto [domain, color] =
        GENERATE(table<std::string, PreviewColor>({{"ball:10", PreviewColor::radius},
                                                   {"box:20,20,20", PreviewColor::region},
                                                   {"ball:10", PreviewColor::depth},
                                                   {"box:20,20,20", PreviewColor::order},
                                                   {"rect:30,20", PreviewColor::radius},
                                                   {"rect:30,20", PreviewColor::region},
                                                   {"rect:30,20", PreviewColor::depth},
                                                   {"rect:30,20", PreviewColor::order}}));
    if (domain != "rect:30,20" && !canDrawSpace()) return;
    CAPTURE(domain, static_cast<int>(color));
    const TemporaryFolder folder;
    auto recipe = drawn(domain, folder.file("a.png"));
    recipe.preview.color = color;
    const auto run = runPack(recipe);
    CHECK(isPng(folder.file("a.png")));
    CHECK(run.report.files == std::vector<std::string>{folder.file("a.png")});
    CHECK(run.picture.png == contentOf(folder.file("a.png")));
    CHECK(run.picture.width == 160);
}

TEST_CASE("clipped, sliced and voided domains are drawn") {
    if (!canDrawSpace()) return;
    const TemporaryFolder folder;
    auto clipped = drawn("ball:10", folder.file("clipped.png"));
    clipped.domain.clips = {parseClip("plane:0,0,1,2")};
    clipped.preview.cut = PreviewCut{0, 1};
    runPack(clipped);
    CHECK(isPng(folder.file("clipped.png")));
    auto sliced = drawn("ball:10", folder.file("sliced.png"));
    sliced.domain.slice = 1;
    runPack(sliced);
    CHECK(isPng(folder.file("sliced.png")));
    auto shelled = drawn("ball:12", folder.file("shelled.png"));
    setVoids(shelled.request, "boolean", "", 0.4);
    shelled.request.shell = 2;
    shelled.preview.color = PreviewColor::region;
    runPack(shelled);
    CHECK(isPng(folder.file("shelled.png")));
}

TEST_CASE("voids alone are drawn as the solid that they leave") {
    const std::string domain = GENERATE("ball:10", "rect:30,20");
    if (domain == "ball:10" && !canDrawSpace()) return;
    CAPTURE(domain);
    const TemporaryFolder folder;
    auto recipe = voidsIn(domain);
    setVoids(recipe.request, "boolean", "uniform:1,2", 0.5);
    recipe.preview.file = folder.file("v.png");
    recipe.preview.width = 160;
    recipe.preview.height = 120;
    const auto run = runVoids(recipe);
    CHECK(isPng(folder.file("v.png")));
    CHECK(run.report.files == std::vector<std::string>{folder.file("v.png")});
}

TEST_CASE("what is carved is drawn") {
    if (!canDrawSpace()) return;
    const TemporaryFolder folder;
    auto pack = recipeFor("ball:10", "uniform:1,2", folder.file("p.csv"));
    runPack(pack);
    auto recipe = onPack<CarveJob>(folder.file("p.csv"), "ball:10");
    setVoids(recipe.request, "boolean", "", 0.5);
    recipe.preview.file = folder.file("c.png");
    recipe.preview.cut = PreviewCut{1, 0};
    const auto run = runCarve(recipe);
    CHECK(isPng(folder.file("c.png")));
    CHECK(run.report.files == std::vector<std::string>{folder.file("c.png")});
}

TEST_CASE("a report page shows the picture, requested or not") {
    const TemporaryFolder folder;
    auto recipe = recipeFor("rect:30,20", "uniform:1,2");
    recipe.reportFile = folder.file("r.html");
    runPack(recipe);
    const auto page = contentOf(folder.file("r.html"));
    CHECK(page.find("<img src='data:image/png;base64,iVBORw0KGgo") != std::string::npos);
    CHECK(page.find("width='960'") != std::string::npos);
    CHECK(page.find("colored by radius") != std::string::npos);
    recipe.preview.file = folder.file("p.png");
    recipe.preview.width = recipe.preview.height = 100;
    runPack(recipe);
    CHECK(contentOf(folder.file("r.html")).find("width='100'") != std::string::npos);
    CHECK(isPng(folder.file("p.png")));
}

TEST_CASE("each seed of a study has its picture") {
    const TemporaryFolder folder;
    auto recipe = drawn("rect:30,20", folder.file("a.png"));
    recipe.preview.file = folder.file("a{seed}.png");
    runStudy({recipe}, {1, 2}, "");
    CHECK(isPng(folder.file("a1.png")));
    CHECK(isPng(folder.file("a2.png")));
    CHECK(contentOf(folder.file("a1.png")) != contentOf(folder.file("a2.png")));
}

TEST_CASE("packs and solids of files are drawn") {
    const TemporaryFolder folder;
    auto recipe = recipeFor("rect:30,20", "uniform:1,2");
    const bool plane = GENERATE(true, false);
    if (!plane) {
        if (!canDrawSpace()) return;
        recipe.domain.source = "ball:8";
    }
    recipe.outputs = {folder.file("p.csv"), folder.file("p.vtp")};
    if (!plane) recipe.outputs.push_back(folder.file("p.stl"));
    runPack(recipe);
    auto convert = onPack<ConvertRecipe>(folder.file("p.csv"));
    convert.preview.width = 160;
    convert.preview.height = 120;
    CHECK_THROWS_AS(runConvert(convert), ParameterError);  // writes nothing
    convert.preview.file = folder.file("bare.png");
    CHECK(runConvert(convert).files == std::vector<std::string>{folder.file("bare.png")});
    CHECK(isPng(folder.file("bare.png")));
    convert.domain.source = recipe.domain.source;
    convert.preview.file = folder.file("wall.png");
    runConvert(convert);
    CHECK(contentOf(folder.file("wall.png")) != contentOf(folder.file("bare.png")));
    if (plane) return;
    ConvertRecipe solid = convert;
    solid.domain.source.clear();
    solid.pack = folder.file("p.stl");
    solid.preview.file = folder.file("solid.png");
    runConvert(solid);
    CHECK(isPng(folder.file("solid.png")));
}

TEST_CASE("a page of parts lists them, and leaves out what is not measured of several") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.domain.source = folder.file("halves.nrrd");
    writeHalves(recipe.domain.source);
    recipe.domain.label = "all";
    recipe.targetCount = 300;
    recipe.reportFile = folder.file("page.html");
    const RunResult run = runPack(recipe);
    const std::string page = contentOf(recipe.reportFile);
    for (const PartReport& part : run.report.parts) CHECK_THAT(page, Contains(part.name));
    CHECK_THAT(page, Contains("Sizes") && !Contains("There are no") && !Contains("chart-pairs"));
}
