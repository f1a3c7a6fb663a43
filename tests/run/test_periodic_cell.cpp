// Periodic cells from the command line to files and back.
#include "support/jobs.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/pack_file.h"

TEST_CASE("a periodic cell is packed, densified, measured and verified") {
    const TemporaryFolder folder;
    auto recipe = recipeFor("periodic:24,22,26", "uniform:1,2");
    recipe.densify.fraction = 0.645;
    recipe.outputs = {folder.file("p.vtp"), folder.file("p.csv")};
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(run.report.solidFractionTotal.value_or(0) >= 0.645);
    CHECK(run.report.solidFractionInterior.value_or(0) ==
          Approx(*run.report.solidFractionTotal));  // there is no layer at a wall
    const auto& pack = std::get<Pack<3>>(run.pack);
    CHECK(pack.cell.all());
    CHECK(pack.depth.empty());
    auto verify = onPack<VerifyRecipe>(folder.file("p.csv"), "periodic:24,22,26");
    CHECK(runVerify(verify, {}).passed);
    // In a shorter cell they overlap across its faces; a file with its own cell needs no domain.
    verify.domain.source = "periodic:24,22,25";
    CHECK(runVerify(verify, {}).report.overlap->pairs > 0);
    verify.domain.source.clear();
    verify.pack = folder.file("p.vtp");
    const auto own = runVerify(verify, {});
    CHECK(own.passed);
    CHECK(std::get<Pack<3>>(own.pack).cell.all());
    CHECK(own.report.solidFractionTotal == run.report.solidFractionTotal);
    CHECK(own.report.warnings.empty());
    verify.domain.source = "periodic:24,22,27";
    REQUIRE(runVerify(verify, {}).report.warnings.size() == 1);
    CHECK_THAT(runVerify(verify, {}).report.warnings[0], Contains("p.vtp") && Contains("24,22,27"));
    auto denser = onPack<DensifyRecipe>(verify.pack);
    denser.densify.fraction = 0.655;
    const auto result = runDensify(denser);
    CHECK(result.passed);
    CHECK(result.report.solidFractionTotal.value_or(0) >= 0.655);
    denser.pack = folder.file("p.csv");
    CHECK_THROWS_AS(runDensify(denser), ParameterError);
}

TEST_CASE("boxes repeat along the axes that are named") {
    auto recipe = recipeFor("box:24,22,26", "uniform:1,2");
    recipe.domain.periodic = parseAxes("xz");
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(run.report.area == Approx(2 * 24 * 26));
    CHECK(std::get<Pack<3>>(run.pack).depth.size() == run.report.count);
}

TEST_CASE("a picture and a page show the spheres of a periodic cell") {
    const TemporaryFolder folder;
    const auto domain = GENERATE(as<std::string>(), "periodic:24,22,26", "periodic:60,50");
    auto recipe = recipeFor(domain, "uniform:1,2");
    recipe.preview.file = folder.file("p.png");
    recipe.reportFile = folder.file("r.html");
    CHECK(runPack(recipe).passed);
    CHECK(std::filesystem::exists(folder.file("p.png")));
}

TEST_CASE("files for viewers hold images where these are asked for") {
    const TemporaryFolder folder;
    const std::string viewed = folder.file("v.csv"), simulated = folder.file("s.data");
    auto recipe = recipeFor("periodic:20,18,22", "uniform:1,2");
    recipe.outputs = {viewed, simulated};
    recipe.images = true;
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    CHECK(readPack(simulated).spheres.size() == pack.spheres.size());
    const Pack<3> all = readPack(viewed);
    REQUIRE(all.spheres.size() > pack.spheres.size());
    const auto of = std::find_if(all.columns.begin(), all.columns.end(),
                                 [](const Column& c) { return c.name == "image_of"; });
    REQUIRE(of != all.columns.end());
    CHECK(all.id.empty());  // those of a .csv are 0, 1, ...: each once
    std::size_t expected = 0;
    for (const Sphere<3>& s : pack.spheres)
        for (int k = 0; k < 27; ++k) {
            const Vec<3> center =
                s.center + Vec<3>{{20.0 * (k % 3 - 1), 18.0 * (k / 3 % 3 - 1), 22.0 * (k / 9 - 1)}};
            bool meets = true;
            for (int d = 0; d < 3; ++d)
                meets = meets && center[d] + s.radius >= pack.cell.box.lo[d] &&
                        center[d] - s.radius <= pack.cell.box.hi[d];
            expected += meets;
        }
    CHECK(all.spheres.size() == expected);
    for (std::size_t i = 0; i < all.spheres.size(); ++i) {
        const auto source = static_cast<std::size_t>(of->numbers[i]);
        CHECK((source == i) == (i < pack.spheres.size()));
        CHECK(all.spheres[i].radius == pack.spheres[source].radius);
        CHECK(length(pack.cell.nearest(all.spheres[i].center - pack.spheres[source].center)) <
              1e-9);
    }
}
