// --size-field and --shell-radius: from files and options to the report.
#include "support/grids.h"
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/core/error.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/run.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>

namespace {

constexpr const char* kBox = "box:24,24,24";

/// From `low` to `high` along x, on a lattice of points around the box.
std::string rampTable(double low, double high, double side = 26) {
    std::string text = "x,y,z,factor\n";
    constexpr int kPoints = 9;
    for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
        const double x = (i % kPoints) / (kPoints - 1.0), y = (i / kPoints % kPoints) / 8.0,
                     z = (i / kPoints / kPoints) / 8.0;
        text += fmt::format("{},{},{},{}\n", (x - 0.5) * side, (y - 0.5) * side, (z - 0.5) * side,
                            low + (high - low) * x);
    }
    return text;
}

/// 0.7 and 1.4 in halves of a .vdb.
void writeTwoFactors(const std::string& file) {
    auto grid = newGrid<openvdb::FloatGrid>(1.0f);
    auto accessor = grid->getAccessor();
    for (int k = -14; k <= 14; ++k)
        for (int j = -14; j <= 14; ++j)
            for (int i = -14; i <= 14; ++i) accessor.setValue({i, j, k}, i < 0 ? 0.7f : 1.4f);
    openvdb::io::File(file).write({grid});
}

PackJob recipeWith(const std::string& field, const std::string& radius = "uniform:1,2") {
    PackJob recipe = recipeFor(kBox, radius);
    recipe.sizeField = field;
    return recipe;
}

}  // namespace

TEST_CASE("sizes follow a table or a grid, and the report says how well") {
    const TemporaryFolder folder;
    std::string file = folder.file("ramp.csv");
    const bool grid = GENERATE(false, true);
    CAPTURE(grid);
    if (grid)
        writeTwoFactors(file = folder.file("halves.vdb"));
    else
        putContent(file, rampTable(0.5, 1));
    const RunResult run = runPack(recipeWith(file));
    CHECK(run.passed);
    REQUIRE(run.report.localSizes.size() == 1);
    const auto& all = run.report.localSizes.front();
    CHECK(all.requested == "uniform:1,2");
    CHECK(all.count == run.report.count);
    CHECK(all.factorLeast == Approx(grid ? 0.7 : 0.5).margin(0.05));
    CHECK(all.factorMost == Approx(grid ? 1.4 : 1.0).margin(0.05));
    CHECK(all.ks < 0.05);
    CHECK(run.report.ks == all.ks);
    CHECK_THAT(summary(run), Contains("by place"));
    CHECK_THAT(toJson(run).dump(), Contains("\"local\""));
}

TEST_CASE("the shell and the inside have radii of their own, before and after densifying") {
    PackJob recipe = recipeFor("ball:14", "uniform:1,2");
    recipe.shellRadius = SizeRequest::parse("uniform:0.5,0.9");
    recipe.request.shell = 3;
    const bool dense = GENERATE(false, true);
    if (dense) recipe.densify.fraction = 0.62;
    CAPTURE(dense);
    const RunResult run = runPack(recipe);
    CHECK(run.passed);
    REQUIRE(run.report.localSizes.size() == 2);
    const auto &shell = run.report.localSizes[0], &inside = run.report.localSizes[1];
    CHECK(shell.name == "shell");
    CHECK(shell.requested == "uniform:0.5,0.9");
    CHECK(inside.requested == "uniform:1,2");
    CHECK(shell.count + inside.count == run.report.count);
    CHECK(shell.ks < 0.05);
    CHECK(inside.ks < 0.1);
    if (dense) CHECK(run.report.solidFractionTotal.value_or(0) >= 0.62 - 1e-9);
}

TEST_CASE("a field densifies with its local sizes") {
    const TemporaryFolder folder;
    putContent(folder.file("ramp.csv"), rampTable(0.5, 1.5));
    PackJob recipe = recipeWith(folder.file("ramp.csv"));
    const auto front = runPack(recipe).report;
    recipe.densify.fraction = *front.solidFractionTotal + 0.02;
    const auto dense = runPack(recipe).report;
    REQUIRE(dense.densified);
    CHECK(*dense.solidFractionTotal >= recipe.densify.fraction - 1e-9);
    CHECK(dense.overlap->max < 1e-6);
    CHECK(dense.localSizes.front().ks < 0.05);
    recipe.threads = 3;
    CHECK(runPack(recipe).report.hash == dense.hash);
}

TEST_CASE("spheres that move keep to the field") {
    const TemporaryFolder folder;
    putContent(folder.file("ramp.csv"), rampTable(0.5, 1.5));
    PackJob recipe = recipeWith(folder.file("ramp.csv"), "constant:1.2");
    const double front = *runPack(recipe).report.solidFractionTotal;
    if (GENERATE(false, true))
        recipe.densify.fraction = front + 0.02;
    else
        recipe.settle = true;
    const auto report = runPack(recipe).report;
    CHECK(*report.solidFractionTotal > front - 1e-9);
    CHECK(report.overlap->max < 1e-6);
    CHECK(report.localSizes.front().ks < 0.05);  // of equal radii: hardly any is off by 5e-4
}

TEST_CASE("a bone densifies whatever the radii leave of its shell", "[long]") {
    struct Case {
        double shell;
        const char *radius, *shellRadius;
    };
    // Below the shell, spheres may just fit between two walls; in it, at the wall alone.
    const Case c = GENERATE(Case{3, "uniform:1.5,3", "uniform:0.75,1.2"},
                            Case{1.4, "uniform:0.8,1.6", "uniform:0.4,0.8"},
                            Case{1.2, "uniform:1.2,2.4", "uniform:0.6,1.2"});
    PackJob recipe = recipeFor(kMeshes + "/mandible.ply", c.radius);
    recipe.request.shell = c.shell;
    recipe.shellRadius = SizeRequest::parse(c.shellRadius);
    CAPTURE(c.shell);
    recipe.densify.fraction = 0.61;
    const auto report = runPack(recipe).report;
    CHECK(*report.solidFractionTotal >= recipe.densify.fraction - 1e-9);
    CHECK(report.overlap->max < 1e-6);
    CHECK(report.protrusion->max < 1e-6);
    for (const auto& group : report.localSizes) CHECK(group.ks < 0.02);
}

TEST_CASE("a warning names a shell that stays empty") {
    PackJob recipe = recipeFor("ball:8", "uniform:0.8,1.6");
    recipe.shellRadius = SizeRequest::parse("uniform:0.4,0.8");
    for (const double thickness : {0.3, 1.6}) {
        CAPTURE(thickness);
        recipe.request.shell = thickness;
        const auto report = runPack(recipe).report;
        const auto empty = std::count_if(
            report.warnings.begin(), report.warnings.end(), [](const std::string& warning) {
                return warning.find("lies in the shell") != std::string::npos;
            });
        CHECK(empty == (thickness < 0.4));
        std::uint64_t inShell = 0;
        for (const auto& group : report.localSizes)
            if (group.name == "shell") inShell = group.count;
        CHECK((inShell > 0) == (thickness > 0.4));
    }
}

TEST_CASE("a recipe file repeats a pack of sizes by place") {
    const TemporaryFolder folder;
    putContent(folder.file("ramp.csv"), rampTable(0.7, 1.4));
    const Output made = vdbPack(
        "pack ball:11 --radius uniform:1,2 --size-field " + folder.file("ramp.csv") +
        " --shell 3 --shell-radius uniform:0.6,1 --quiet --json -o " + folder.file("pack.csv"));
    const Output again =
        vdbPack("pack --config " + folder.file("pack.recipe.toml") + " --quiet --json");
    CHECK(jsonOf(made)["hash"] == jsonOf(again)["hash"]);
    CHECK_THAT(contentOf(folder.file("pack.recipe.toml")), Contains("ramp.csv"));
}

TEST_CASE("a dry run foresees the count of sizes by place") {
    const TemporaryFolder folder;
    putContent(folder.file("ramp.csv"), rampTable(0.3, 1.2));
    PackJob recipe = recipeWith(folder.file("ramp.csv"), "uniform:0.5,1");
    const auto count = static_cast<double>(runPack(recipe).report.count);
    CHECK(dryRunPack(settled(recipe)).count == Approx(count).epsilon(0.15));
}
