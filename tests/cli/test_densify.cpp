// pack --densify and vdb_pack densify.
#include "support/jobs.h"
#include "support/limited_tool.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/formats/pack_file.h"

#include <fmt/ranges.h>

TEST_CASE("pack --densify reaches the fraction, and its report says how") {
    auto recipe = recipeFor("box:30,30,30", "uniform:1,2");
    const auto before = runPack(recipe);
    recipe.densify.fraction = 0.62;
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(run.report.solidFractionTotal.value_or(0) >= 0.62);
    REQUIRE(run.report.densified.has_value());
    const auto& told = *run.report.densified;
    CHECK(told.before == Approx(*before.report.solidFractionTotal));
    CHECK(told.after == Approx(*run.report.solidFractionTotal));
    CHECK(told.inserted == run.report.count - before.report.count);
    CHECK(told.steps > 0);
    CHECK(told.contactsBefore[0] > 2);
    REQUIRE(told.contactsAfter.has_value());
    CHECK((*told.contactsAfter)[2] > (*told.contactsAfter)[1]);
    CHECK((*told.contactsAfter)[0] > 4);
    const auto json = toJson(run);
    CHECK(json["densified"]["asked"] == 0.62);
    CHECK(json["densified"]["contacts"].size() == 3);
    CHECK(json["seconds"]["densify"] > 0);
    CHECK(toJson(before)["densified"].is_null());
    Report report = run.report;
    CHECK_THAT(summary(report), Contains("densified  from 0.5") && !Contains("contactTolerance"));
    // Where hardly any could be drawn together.
    (*report.densified->contactsAfter)[0] = 0.3;
    CHECK_THAT(summary(report), Contains("`contactTolerance` 0.01"));
    report.contactTolerance = 0.01;
    CHECK_THAT(summary(report), !Contains("contactTolerance"));
    // One name and one place in the order each.
    const auto& pack = std::get<Pack<3>>(run.pack);
    CHECK(pack.order.size() == pack.spheres.size());
    CHECK(pack.order.back() == static_cast<std::int64_t>(pack.spheres.size()) - 1);
}

TEST_CASE("existing spheres stay while the others get denser") {
    const TemporaryFolder folder;
    auto standing = recipeFor("ball:6", "uniform:1,2", folder.file("a.csv"));
    const auto first = std::get<Pack<3>>(runPack(standing).pack).spheres;
    auto recipe = recipeFor("box:26,26,26", "uniform:1,2");
    recipe.existing = folder.file("a.csv");
    recipe.densify.fraction = 0.59;
    const auto run = runPack(recipe);
    CHECK(run.passed);
    const auto& pack = std::get<Pack<3>>(run.pack);
    REQUIRE(run.report.existing == first.size());
    for (std::size_t i = 0; i < first.size(); ++i) CHECK(pack.spheres[i] == first[i]);
    REQUIRE(pack.columns.size() == 1);
    CHECK(pack.columns[0].numbers.size() == pack.spheres.size());
    CHECK(run.report.solidFractionTotal.value_or(0) > 0.585);
}

TEST_CASE("equal spheres that crystallize while they are densified are reported") {
    const auto warningsAt = [](double fraction) {
        auto recipe = recipeFor("box:30,30,30", "constant:1");
        recipe.densify.fraction = fraction;
        const Report report = runPack(recipe).report;
        REQUIRE(report.densified);
        std::size_t named = 0;
        for (const std::string& warning : report.warnings)
            named += warning.find("crystalline") != std::string::npos;
        CHECK((report.densified->solidLike.value_or(0) > 0.07) == (named == 1));
        return named;
    };
    CHECK(warningsAt(0.585) == 0);
    CHECK(warningsAt(0.615) == 1);
    CHECK(warningsAt(std::numeric_limits<double>::infinity()) == 1);
}

TEST_CASE("a densified pack has the requested count") {
    auto recipe = recipeFor("ball:20", "uniform:1,2");
    recipe.targetCount = 3000;
    recipe.densify.fraction = 0.625;
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(static_cast<double>(run.report.count) == Approx(3000).epsilon(0.02));
    CHECK(run.report.solidFractionTotal.value_or(0) >= 0.625);
}

TEST_CASE("voids are cut after a pack got denser") {
    auto recipe = recipeFor("box:24,24,24", "uniform:1,2");
    recipe.densify.fraction = 0.61;
    setVoids(recipe.request, "boolean", "constant:3", 0.8);
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(run.report.densified->after >= 0.61);
    CHECK(run.report.voids->culled > 0);
    CHECK(run.report.ks.value_or(1) < 0.05);
}

TEST_CASE("densify takes packs of other programs, with their names and columns") {
    const TemporaryFolder folder;
    std::ofstream(folder.file("p.csv"))
        << ("id,x,y,z,radius,material\n7,0,0,0,1,bone\n3,1.5,0,0,1,tooth\n"
            "9,-4.5,0,0,1,bone\n");
    const auto run = vdbPack("densify " + folder.file("p.csv") + " --domain box:10,10,10 -o " +
                             folder.file("q.csv"));
    CAPTURE(run.text);
    CHECK(run.code == 0);
    const auto pack = readPack(folder.file("q.csv"));
    REQUIRE(pack.spheres.size() == 3);
    CHECK(pack.id == std::vector<std::int64_t>{7, 3, 9});
    REQUIRE(pack.columns.size() == 1);
    CHECK(pack.columns[0].texts == std::vector<std::string>{"bone", "tooth", "bone"});
    CHECK(gap(pack.spheres[0], pack.spheres[1]) > 0);
    CHECK(pack.spheres[2].center[0] >= -4);
    const auto more = vdbPack("densify " + folder.file("p.csv") +
                              " --domain box:10,10,10 --densify 0.3 --radius uniform:0.5,1 -o " +
                              folder.file("r.vdb") + " --report " + folder.file("r.json"));
    CAPTURE(more.text);
    CHECK(more.code == 0);
    CHECK(vdbPack("verify " + folder.file("r.vdb") + " --domain box:10,10,10").code == 0);
    // The recipe beside it makes the same again.
    const auto again = vdbPack("densify --config " + folder.file("r.recipe.toml"));
    CAPTURE(again.text);
    CHECK(again.code == 0);
}

TEST_CASE("densify adds spheres to the regions that a pack has") {
    const TemporaryFolder folder;
    auto recipe = recipeFor("box:24,24,24", "uniform:1,2", folder.file("p.csv"));
    recipe.request.shell = 4;
    const auto before = std::get<Pack<3>>(runPack(recipe).pack);
    const auto run = vdbPack("densify " + folder.file("p.csv") +
                             " --domain box:24,24,24 --densify 0.61 -o " + folder.file("q.csv"));
    CAPTURE(run.text);
    CHECK(run.code == 0);
    const auto pack = readPack(folder.file("q.csv"));
    const std::size_t n = before.spheres.size();
    REQUIRE(pack.region.size() == pack.spheres.size());
    REQUIRE(pack.spheres.size() > n + 10);
    CHECK(std::equal(before.region.begin(), before.region.end(), pack.region.begin()));
    for (const std::int32_t region : {0, 1}) {
        CAPTURE(region);
        CHECK(std::count(pack.region.begin() + static_cast<std::ptrdiff_t>(n), pack.region.end(),
                         region) > 0);
    }
}

TEST_CASE("a pack that cannot be separated is written as it was, with exit code 1") {
    const TemporaryFolder folder;
    std::string text = "x,y,z,radius\n";
    for (int i = 0; i < 40; ++i) text += "0.0,0.0," + std::to_string(i * 0.01) + ",1\n";
    std::ofstream(folder.file("p.csv")) << text;
    const auto run = vdbPack("densify " + folder.file("p.csv") + " --domain box:4,4,4 -o " +
                             folder.file("q.csv"));
    CHECK(run.code == 1);
    CHECK_THAT(run.text, Contains("overlaps"));
    CHECK(readPack(folder.file("q.csv")).spheres == readPack(folder.file("p.csv")).spheres);
}

TEST_CASE("densify tells what it does not keep") {
    const TemporaryFolder folder;
    auto recipe = recipeFor("periodic:16,16,16", "uniform:1,1.5", folder.file("cell.vtp"));
    runPack(recipe);
    auto again = onPack<DensifyRecipe>(folder.file("cell.vtp"));
    again.densify.fraction = 0.61;
    CHECK(runDensify(again).report.warnings.empty());
    for (const std::string other : {"box:16,16,16", "periodic:17,16,16"}) {
        again.domain.source = other;
        const auto warnings = runDensify(again).report.warnings;
        CAPTURE(other);
        REQUIRE_FALSE(warnings.empty());
        CHECK_THAT(warnings.front(), Contains("periodic cell"));
    }
    // A pack with holes.
    auto sparse = recipeFor("box:20,20,20", "uniform:1,1.5", folder.file("sparse.csv"));
    sparse.packing.gap = 1;
    runPack(sparse);
    again = {};
    again.pack = folder.file("sparse.csv");
    again.domain.source = "box:20,20,20";
    CHECK(runDensify(again).report.warnings.empty());
    again.densify.fraction = 0.4;
    const auto warnings = runDensify(again).report.warnings;
    REQUIRE_FALSE(warnings.empty());
    CHECK_THAT(warnings.front(), Contains("voids"));
}

TEST_CASE("a solid fraction that the front has, or no pack, is warned of before the work") {
    auto recipe = recipeFor("ball:9", "uniform:1,2");
    recipe.densify.fraction = 0.3;
    CHECK_THAT(fmt::format("{}", fmt::join(warningsOf(recipe), "\n")),
               Contains("`densify` 0.3") && Contains("`start` random"));
    recipe.densify.fraction = 0.55;
    CHECK_THAT(fmt::format("{}", fmt::join(warningsOf(recipe), "\n")), !Contains("hardly"));
    for (const bool random : {false, true}) {
        recipe.randomStart = random;
        recipe.densify.fraction = 0.9;
        CHECK_THAT(fmt::format("{}", fmt::join(warningsOf(recipe), "\n")), Contains("hardly"));
    }
    recipe.densify.fraction = 0.4;
    recipe.packing.effort = Effort::dense;
    CHECK_THAT(fmt::format("{}", fmt::join(warningsOf(recipe), "\n")),
               Contains("`effort` has no effect"));
}

TEST_CASE("a pack outside of its domain is refused before it is densified") {
    const TemporaryFolder folder;
    putContent(folder.file("p.csv"), "x,y,z,radius\n0,0,0,1\n40,0,0,1\n43,0,0,1\n");
    const auto run =
        vdbPack("densify " + folder.file("p.csv") + " --domain ball:9 --densify 0.5 --json");
    CHECK(run.code == 3);
    CHECK_THAT(run.text, Contains("2 of 3 centers") && Contains("--pack-unit"));
}
