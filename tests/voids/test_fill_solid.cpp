// Runs that fill what voids leave, and counts that include what voids remove.
#include "support/generators.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/test.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/report/report.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/cull.h"

namespace {

PackJob porousBall(const std::string& source) {
    PackJob recipe = recipeFor(source, "uniform:0.25,0.5");
    setVoids(recipe.request, "boolean", "constant:1.2", 0.4);
    recipe.request.aspect = "constant:1.5";
    recipe.request.shell = 1.5;
    return recipe;
}

}  // namespace

TEST_CASE("the solid beside voids is filled in one run, inside the bone and the written solid") {
    const TemporaryFolder folder;
    const std::string bone = folder.file("ball.obj");
    writeObj(ballMesh(8, 3), bone);
    PackJob recipe = porousBall(bone);
    recipe.request.fill = Fill::solid;
    recipe.request.keepConnected = true;
    recipe.outputs = {folder.file("solid.vdb")};
    const RunResult run = runPack(recipe);
    REQUIRE(run.passed);
    CHECK(run.report.voids->bvtv.value() == Approx(0.4).margin(0.005));
    CHECK(run.report.voids->culled == 0);
    REQUIRE(run.report.count > 1000);
    CHECK(run.report.contacts->largestComponent > 0.99);

    // Against both walls, by verify itself.
    for (const bool solid : {false, true}) {
        CAPTURE(solid);
        auto verify =
            onPack<VerifyRecipe>(recipe.outputs[0].text, solid ? recipe.outputs[0].text : bone);
        if (solid) verify.domain.gridName = "solid";
        const RunResult check = runVerify(verify);
        CHECK(check.passed);
        CHECK(check.report.protrusion->spheres == 0);
    }

    // The regions are those of the bone's own surface, not of the walls of the voids.
    const auto& pack = std::get<Pack<3>>(run.pack);
    const auto domain = meshDomain(ballMesh(8, 3), FieldOptions::forRadii(0.25, 0.5));
    CHECK(pack.region == deeperThan(pack.spheres, *domain, 1.5));
    CHECK(std::count(pack.region.begin(), pack.region.end(), 1) > 100);
}

TEST_CASE("more of the solid is filled when it is filled than when it is cut from a pack") {
    PackJob recipe = porousBall("ball:8");
    recipe.request.shell = 0;
    recipe.request.targetBvtv = 0.3;
    const auto solidVolume = [](const RunResult& run) {
        double sum = 0;
        for (const auto& s : std::get<Pack<3>>(run.pack).spheres) sum += std::pow(s.radius, 3);
        return sum;
    };
    recipe.request.cull = Cull::touch;
    const double cut = solidVolume(runPack(recipe));
    recipe.request.cull = Cull::center;
    recipe.request.fill = Fill::solid;
    CHECK(solidVolume(runPack(recipe)) > 1.2 * cut);
}

TEST_CASE("spheres that fill little of a solid are warned of") {
    PackJob recipe = porousBall("ball:8");
    recipe.request.fill = Fill::solid;
    CHECK_FALSE(mentions(warningsOf(recipe), "between the voids"));
    recipe.radius = SizeRequest::parse("uniform:0.4,0.8");
    recipe.request.targetBvtv = 0.2;
    CHECK(mentions(warningsOf(recipe), "between the voids"));
}

TEST_CASE("a target count is the number of spheres that are written") {
    struct Case {
        const char* what;
        void (*change)(PackJob&);
    };
    const Case c = GENERATE(
        Case{"spheres in voids do not count", [](PackJob&) {}},
        Case{"nor those that are not connected",
             [](PackJob& r) { r.request.keepConnected = true; }},
        Case{"nor those that voids touch", [](PackJob& r) { r.request.cull = Cull::touch; }},
        Case{"those that densifying adds do", [](PackJob& r) { r.densify.fraction = 0.62; }},
        Case{"and those that nearly touch after it, which stay connected",
             [](PackJob& r) { r.densify.fraction = 0.62, r.request.keepConnected = true; }},
        Case{
            "holes among the spheres do not",
            [](PackJob& r) { r.request = {}, setVoids(r.request, "mixed", "constant:1.2", 0.75); }},
        Case{"in the solid alone", [](PackJob& r) { r.request.fill = Fill::solid; }});
    PackJob recipe = porousBall("ball:8");
    recipe.radius = SizeRequest::parse("uniform:1,2");
    recipe.targetCount = 3000;
    c.change(recipe);
    CAPTURE(c.what);
    CHECK(static_cast<double>(runPack(recipe).report.count) == Approx(3000).epsilon(0.02));
}

TEST_CASE("the voids around a solid have one size in all rounds of a target count", "[.slow]") {
    PackJob recipe = porousBall("ball:10");
    recipe.radius = SizeRequest::parse("uniform:1,2");
    recipe.targetCount = 4000;
    recipe.request.fill = Fill::solid;
    recipe.request.radius.clear();  // from the radii of the spheres
    recipe.request.keepConnected = true;
    recipe.densify.fraction = 0.62;
    const RunResult run = runPack(recipe);
    CHECK(static_cast<double>(run.report.count) == Approx(4000).epsilon(0.02));
}

TEST_CASE("a dry run predicts the spheres that voids leave, and the time of the voids") {
    PackJob recipe = porousBall("ball:10");
    const DryRun expected = dryRunPack(settled(recipe));
    CHECK(expected.seconds.voids > 0);
    CHECK(expected.count == Approx(static_cast<double>(runPack(recipe).report.count)).epsilon(0.1));
}

TEST_CASE("a target count knows how thin the domain is") {
    // Of 1000, the largest are as wide as the domain, and the count jumps where they no longer fit.
    PackJob recipe = recipeFor("box:4,4,3000", "");
    for (const double target : {1000, 1500, 2500}) {
        recipe.targetCount = target;
        const RunResult run = runPack(recipe);
        CAPTURE(target, run.report.count);
        CHECK(run.passed);
        const double off = std::fabs(static_cast<double>(run.report.count) / target - 1);
        if (target == 1000 && mentions(run.report.warnings, "nearest count"))
            CHECK(off < 0.1);
        else
            CHECK(off < 0.02);
    }
}

TEST_CASE("small target counts are met or warned of, and are whole numbers") {
    const double target = GENERATE(1, 2, 3, 5, 12);
    CAPTURE(target);
    PackJob recipe = recipeFor("box:20,20,20", "");
    recipe.targetCount = target;
    const RunResult run = runPack(recipe);
    if (static_cast<double>(run.report.count) != target)
        CHECK(mentions(run.report.warnings, "targetCount"));
    recipe.targetCount = target + 0.5;
    CHECK_THROWS_AS(runPack(recipe), ParameterError);
}

TEST_CASE("extreme targets of BV/TV are met or warned of") {
    const double target = GENERATE(0.001, 0.999);
    CAPTURE(target);
    auto recipe = voidsIn("ball:6");
    setVoids(recipe.request, "boolean", "constant:1.5", target);
    std::optional<RunResult> run;
    try {
        run = runVoids(recipe);
    } catch (const ParameterError&) {
        return;  // out of reach, with the bound
    }
    const double off = std::fabs(run->report.voids->bvtv.value() - target);
    if (off > 0.02 * std::min(target, 1 - target))
        CHECK(mentions(run->report.warnings, "targetBvtv"));
}

TEST_CASE("voids smaller than the spheres are warned of, with both sizes") {
    PackJob recipe = recipeFor("ball:8", "constant:1");
    setVoids(recipe.request, "boolean", "constant:0.5", 0.6);
    CHECK(mentions(warningsOf(recipe), "0.5"));
    recipe.radius = SizeRequest::parse("constant:0.4");
    recipe.request.radius = "constant:1.5";
    CHECK_FALSE(mentions(warningsOf(recipe), "smaller than the spheres"));
}

TEST_CASE("a pack of which voids leave loose spheres is warned of") {
    PackJob recipe = recipeFor("ball:8", "uniform:0.4,0.8");
    setVoids(recipe.request, "boolean", "constant:1.5", 0.15);
    const RunResult run = runPack(recipe);
    REQUIRE(run.report.voids->spheresAttached.value() < 0.9);
    CHECK(mentions(run.report.warnings, "keepConnected"));
    recipe.request.keepConnected = true;
    const RunResult kept = runPack(recipe);
    CHECK_FALSE(mentions(kept.report.warnings, "Set `keepConnected`"));
    CHECK(kept.report.contacts->components == 1);
}

TEST_CASE("existing spheres that reach into voids are kept where the solid is filled") {
    const TemporaryFolder folder;
    PackJob first = recipeFor("ball:8", "constant:1", folder.file("first.csv"));
    first.packing.maxCount = 60;
    runPack(first);
    PackJob recipe = porousBall("ball:8");
    recipe.request.fill = Fill::solid;
    recipe.existing = folder.file("first.csv");
    const RunResult run = runPack(recipe);
    CHECK(run.report.inputProtrusions > 0);
    CHECK(run.passed);
}

TEST_CASE("a pack whose radii hardly fit is warned of") {
    // Walls of 0.6 mm, which are thicker at edges alone.
    const TemporaryFolder folder;
    writeObj(merged(boxMesh({{0, 0, 0}}, {{6, 6, 6}}),
                    flipped(boxMesh({{0.6, 0.6, 0.6}}, {{5.4, 5.4, 5.4}}))),
             folder.file("hollow.obj"));
    CHECK(mentions(warningsOf(recipeFor(folder.file("hollow.obj"), "uniform:0.36,0.6")),
                   "hardly fit"));
    CHECK_FALSE(mentions(warningsOf(recipeFor("box:20,20,20", "uniform:1,2")), "hardly fit"));
}

TEST_CASE("a pack in which few of the larger radii found room is warned of") {
    const char* const asked = "not those requested";
    CHECK(mentions(warningsOf(recipeFor("box:90,90,3", "uniform:0.6,1.6")), asked));
    CHECK(mentions(warningsOf(recipeFor("box:30,30,3", "uniform:1.4,3")), asked));
    CHECK_FALSE(mentions(warningsOf(recipeFor("box:90,90,3", "uniform:0.6,1.2")), asked));
}

TEST_CASE("the shell of a filled solid is that of the bone") {
    const TemporaryFolder folder;
    PackJob recipe = porousBall("ball:8");
    recipe.request.fill = Fill::solid;
    recipe.reportFile = folder.file("page.html");
    const auto run = runPack(recipe);
    REQUIRE(run.report.voids);
    const std::uint64_t cortical = run.report.voids->cortical;
    REQUIRE(cortical > 100);
    REQUIRE(run.report.count > cortical + 100);
    const std::string page = contentOf(recipe.reportFile);
    for (const std::uint64_t n : {cortical, run.report.count - cortical})
        CHECK(page.find("<td>" + grouped(n) + "</td>") != std::string::npos);
}
