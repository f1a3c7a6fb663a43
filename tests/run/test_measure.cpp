#include "support/generators.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/test.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"

#include <nlohmann/json.hpp>

namespace {

std::vector<std::vector<std::string>> rowsOf(const std::string& file) {
    std::ifstream in(file);
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(in, line);) {
        rows.emplace_back();
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
}

/// What tells where a front began is there, and the same.
void checkTraces(const Report& report, const Report& made) {
    CHECK(report.contacts->fabric == made.contacts->fabric);
    CHECK(report.contacts->modulusRatio == made.contacts->modulusRatio);
    CHECK(report.contacts->modulusRatio > 1);
    CHECK(report.massOffset->axes == made.massOffset->axes);
    CHECK(report.massOffset->share > 0);
}

}  // namespace

TEST_CASE("measure tells of a file what the packer told of the pack") {
    const TemporaryFolder folder;
    writeObj(ballMesh(15, 4), folder.file("b.obj"));
    for (const auto& [domain, radius] :
         {std::make_pair(std::string("box:40,40,40"), "uniform:1,2"),
          std::make_pair(folder.file("b.obj"), "lognormal:1,0.3,0.5,2"),
          std::make_pair(std::string("rect:60,60"), "constant:1")}) {
        CAPTURE(domain);
        const RunResult made = runPack(recipeFor(domain, radius, folder.file("p.csv")));
        auto recipe =
            onPack<MeasureRecipe>(folder.file("p.csv"), domain, "contacts:" + folder.file("c.csv"));
        recipe.radius = SizeRequest::parse(radius);
        recipe.shell = 2;
        recipe.reportFile = folder.file("r.json");
        const MeasureResult result = runMeasure(recipe);
        const Report& report = result.run.report;
        CHECK(report.hash == made.report.hash);
        CHECK(*report.ks == Approx(*made.report.ks));
        CHECK(*report.ksByVolume == Approx(*made.report.ksByVolume));
        CHECK(report.wallSizes->count == made.report.wallSizes->count);
        CHECK(*report.solidFractionTotal == Approx(*made.report.solidFractionTotal).epsilon(1e-3));
        CHECK(report.contacts->histogram == made.report.contacts->histogram);
        checkTraces(report, made.report);

        // The profile and the regions hold what the whole holds.
        const Structure& structure = result.structure;
        REQUIRE(structure.profile);
        REQUIRE(structure.regions.size() == 2);
        double solid = 0, volume = 0, radii = 0;
        std::uint64_t count = 0;
        for (const auto& region : structure.regions) {
            count += region.count;
            radii += static_cast<double>(region.count) * region.meanRadius;
            volume += region.volume;
            solid += region.volume * region.solidFraction;
        }
        CHECK(count == report.count);
        CHECK(structure.regions[1].count > 0);
        CHECK(radii == Approx(static_cast<double>(count) * report.radius.mean));
        CHECK(volume == Approx(report.volume));
        CHECK(solid == Approx(*report.solidFractionTotal * report.volume).epsilon(1e-6));
        CHECK(structure.regions[0].solidFraction < structure.regions[1].solidFraction);

        // One row a touching pair, both of which it names.
        const auto rows = rowsOf(folder.file("c.csv"));
        CHECK(rows.size() == report.contacts->pairs + 1);
        const auto& spheres = readPack(recipe.pack).spheres;
        for (std::size_t k = 1; k < rows.size(); k += 97) {
            const auto& a = spheres[std::stoul(rows[k][0])];
            const auto& b = spheres[std::stoul(rows[k][1])];
            CHECK(std::stod(rows[k][2]) == Approx(gap(a, b)).margin(1e-12));
            CHECK(std::stod(rows[k][2]) < 1e-3 * std::min(a.radius, b.radius));
        }
        const auto json = nlohmann::json::parse(contentOf(folder.file("r.json")));
        CHECK(json["profile"]["fraction"].size() == structure.profile->fraction.size());
        CHECK(json["regions"]["parts"].size() == 2);
        CHECK(json["regions"]["parts"][0]["count"] == structure.regions[0].count);
        CHECK(json["contacts"]["fabric"]["eigenvalues"].size() == (domain[0] == 'r' ? 2 : 3));
    }
}

TEST_CASE("measure needs no domain") {
    const TemporaryFolder folder;
    const RunResult made = runPack(recipeFor("box:80,80,80", "uniform:1,2", folder.file("p.vtp")));
    auto recipe = onPack<MeasureRecipe>(folder.file("p.vtp"));
    const auto result = runMeasure(recipe);
    CHECK(result.run.report.contacts->pairs == made.report.contacts->pairs);
    CHECK_FALSE(result.structure.profile);
    CHECK_FALSE(result.structure.pairCorrelation);
    // What a file says of a wall that is not there counts for nothing.
    CHECK(made.report.contacts->wallContacts > 0);
    CHECK(result.run.report.contacts->wallContacts == 0);
    CHECK_FALSE(result.run.report.massOffset);
    CHECK(result.run.report.contacts->mean == Approx(made.report.contacts->meanOfSpheres));
    recipe.domain.source = "box:80,80,80";
    const auto boxed = runMeasure(recipe);
    {
        std::string warned;
        Callbacks callbacks;
        callbacks.warning = [&](const std::string& text) { warned += text; };
        MeasureRecipe thick = recipe;
        thick.shell = 40;
        CHECK(runMeasure(thick, callbacks).structure.regions.size() == 1);
        CHECK_THAT(warned, Contains("`shell` 40"));
    }
    // Beyond the first shells a random pack has no order.
    const auto& g = boxed.structure.pairCorrelation->g;
    double tail = 0;
    for (std::size_t b = g.size() * 3 / 4; b < g.size(); ++b) tail += g[b];
    CHECK(tail / static_cast<double>(g.size() - g.size() * 3 / 4) == Approx(1).epsilon(0.04));
    // In a part of it, what lies in that part counts.
    recipe.domain.source = "box:40,40,40";
    const auto part = runMeasure(recipe);
    CHECK_FALSE(part.run.report.massOffset);  // spheres lie outside
    CHECK(*part.run.report.solidFractionTotal == Approx(0.64).epsilon(0.02));
    // The deepest layers are smaller than a sphere.
    const auto& fractions = part.structure.profile->fraction;
    REQUIRE(fractions.size() > 10);
    for (std::size_t b = 0; b + 4 < fractions.size(); ++b) CHECK(fractions[b] < 0.8);
}

TEST_CASE("circles are distinguished from spheres where no domain says so") {
    const TemporaryFolder folder;
    const RunResult made = runPack(recipeFor("rect:40,40", "uniform:1,2", folder.file("p.csv")));
    auto recipe = onPack<MeasureRecipe>(folder.file("p.csv"));
    const auto result = runMeasure(recipe);
    CHECK(result.run.report.dim == 2);
    CHECK(result.run.report.contacts->few == 3);
    CHECK(result.run.report.contacts->pairs == made.report.contacts->pairs);
    recipe.domain.source = "rect:40,40";
    recipe.sphereMorphometry = true;
    CHECK_THROWS_WITH(runMeasure(recipe), Contains("p.csv") && Contains("`sphereMorphometry`"));
}

TEST_CASE("measure takes the morphometry of a level set and of a mesh") {
    const TemporaryFolder folder;
    writeObj(ballMesh(10, 5), folder.file("b.obj"));
    PackJob pack = recipeFor(folder.file("b.obj"), "uniform:1,2", folder.file("p.vdb"));
    pack.domain.voxelSize = 0.4;
    runPack(pack);
    const double ball = Measure<3>::ball(10);
    auto recipe = onPack<MeasureRecipe>(folder.file("p.vdb"));
    // It holds a pack and a level set: the pack, unless the other is named.
    CHECK_FALSE(runMeasure(recipe).morphometry);
    recipe.domain.gridName = "surface";
    const auto alone = runMeasure(recipe);
    REQUIRE(alone.morphometry);
    CHECK(alone.morphometry->solidVolume == Approx(ball).epsilon(0.01));
    CHECK(alone.morphometry->solidFraction == Approx(kPi / 6).epsilon(0.05));
    CHECK(alone.morphometry->thickness->mean == Approx(20).epsilon(0.01));
    CHECK(alone.morphometry->eulerNumber == 1);

    recipe.domain.source = "box:24,24,24";
    const auto boxed = runMeasure(recipe);
    CHECK(boxed.morphometry->totalVolume == Approx(24 * 24 * 24).epsilon(0.05));
    CHECK(boxed.morphometry->solidVolume == Approx(ball).epsilon(0.01));
    recipe.domain.source = "ball:10";
    recipe.shell = 2;
    const auto shell = runMeasure(recipe);
    REQUIRE(shell.morphometry->regions.size() == 2);
    CHECK(shell.morphometry->regions[0].totalVolume ==
          Approx(ball - Measure<3>::ball(8)).epsilon(0.02));
    CHECK(shell.morphometry->regions[1].totalVolume == Approx(Measure<3>::ball(8)).epsilon(0.02));
    CHECK(shell.morphometry->regions[1].solidFraction == 1);

    MeasureRecipe mesh;
    writeObj(scaled(ballMesh(10, 5), 1e-3), folder.file("m.obj"));
    mesh.pack = folder.file("m.obj");
    mesh.packUnit = Unit::meter;
    mesh.domain.voxelSize = 0.5;
    const auto of = runMeasure(mesh);
    CHECK(of.morphometry->voxelSize == Approx(0.5));
    CHECK(of.morphometry->solidVolume == Approx(ball).epsilon(0.01));
    const auto json = toJson(of);
    CHECK(json["morphometry"]["Tb.Th"]["mean"].get<double>() == Approx(20).epsilon(0.01));

    mesh.outputs = {"contacts:" + folder.file("c.csv")};
    CHECK_THROWS_WITH(runMeasure(mesh), Contains("c.csv"));
    mesh.outputs.clear();
    mesh.domain.source = "disc:3";
    CHECK_THROWS_WITH(runMeasure(mesh), Contains("plane"));
    recipe.domain.gridName = "solid";
    CHECK_THROWS_WITH(runMeasure(recipe), Contains("solid"));
}

TEST_CASE("a study makes the packs that single runs make") {
    const TemporaryFolder folder;
    writeObj(ballMesh(12, 4), folder.file("b.obj"));
    PackJob recipe = recipeFor(folder.file("b.obj"), "", folder.file("p{seed}.csv"));
    recipe.targetCount = 600;
    recipe.reportFile = folder.file("p{seed}.json");
    const std::vector<std::uint64_t> seeds{3, 1, 20};
    const StudyResult study = runStudy({recipe}, seeds, folder.file("t.csv"));
    REQUIRE(study.passed);
    REQUIRE(study.reports.size() == 3);
    const auto rows = rowsOf(folder.file("t.csv"));
    REQUIRE(rows.size() == 4);
    for (std::size_t k = 0; k < seeds.size(); ++k) {
        PackJob alone = recipe;
        alone.seed = seeds[k];
        alone.outputs = {folder.file("alone.csv")};
        alone.reportFile.clear();
        const RunResult run = runPack(alone);
        CAPTURE(seeds[k]);
        CHECK(run.report.hash == study.reports[k].hash);
        CHECK(rows[k + 1][0] == std::to_string(seeds[k]));
        CHECK(rows[k + 1][1] == hashText(run.report.hash));
        CHECK(rows[k + 1].size() == rows[0].size());
        const auto written = readPack(folder.file("p" + std::to_string(seeds[k]) + ".csv"));
        CHECK(packHash(written) == run.report.hash);
        CHECK(std::filesystem::exists(folder.file("p" + std::to_string(seeds[k]) + ".json")));
    }
    CHECK(study.reports[0].hash != study.reports[1].hash);
    // The field is made once.
    CHECK(study.reports[0].seconds.domain > 0);
    CHECK(study.reports[1].seconds.domain == 0);

    recipe.reportFile.clear();
    recipe.outputs = {folder.file("q{seed}.csv")};
    // A run that fails takes no row with it.
    Callbacks spoiling;
    spoiling.progress = [&](const Progress&) {
        if (std::filesystem::exists(folder.file("q1.csv")))
            std::filesystem::create_directory(folder.file("q20.csv"));
    };
    CHECK_THROWS_AS(runStudy({recipe}, seeds, folder.file("kept.csv"), spoiling), IoError);
    CHECK(rowsOf(folder.file("kept.csv")).size() == 3);
}

namespace {

/// The cell of a row under a name of the first row.
std::string cellOf(const std::vector<std::vector<std::string>>& rows, std::size_t row,
                   const std::string& name) {
    CAPTURE(name);
    const auto found = std::find(rows[0].begin(), rows[0].end(), name);
    REQUIRE(found != rows[0].end());
    return rows[row].at(static_cast<std::size_t>(found - rows[0].begin()));
}

}  // namespace

TEST_CASE("a study in which seeds change nothing is warned of") {
    const auto sameOf = [](const std::string& radius) {
        Listener listener;
        runStudy({recipeFor("box:15,15,15", radius)}, {1, 2}, "", listener.callbacks);
        return listener.heard("the same pack");
    };
    CHECK(sameOf("constant:1"));
    CHECK_FALSE(sameOf("uniform:0.9,1.1"));
}

TEST_CASE("the table of a study has BV/TV, regions and connectivity") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("ball:6", "uniform:0.5,1");
    setVoids(recipe.request, "boolean", "constant:1", 0.6);
    recipe.request.shell = 2;
    const StudyResult study = runStudy({settled(recipe)}, {1, 2}, folder.file("t.csv"));
    const auto rows = rowsOf(folder.file("t.csv"));
    for (std::size_t k = 0; k < 2; ++k) {
        const Report& report = study.reports[k];
        CHECK(std::stod(cellOf(rows, k + 1, "bvtv")) == Approx(*report.voids->bvtv));
        const auto cortical = std::stoull(cellOf(rows, k + 1, "cortical"));
        CHECK(cortical == report.voids->cortical);
        CHECK(cortical + std::stoull(cellOf(rows, k + 1, "trabecular")) == report.count);
        CHECK(std::stod(cellOf(rows, k + 1, "largest_component")) ==
              Approx(report.contacts->largestComponent));
    }
    CHECK_THAT(summary(study), Contains("BV/TV") && Contains("cortical"));
    // Without voids there are none.
    runStudy({recipeFor("ball:4", "constant:1")}, {1}, folder.file("p.csv"));
    CHECK(cellOf(rowsOf(folder.file("p.csv")), 1, "bvtv").empty());
}

TEST_CASE("voids of several seeds are those of single runs, a row each") {
    const TemporaryFolder folder;
    writeObj(ballMesh(6, 3), folder.file("b.obj"));
    auto recipe = voidsIn(folder.file("b.obj"), "list:" + folder.file("v{seed}.csv"));
    setVoids(recipe.request, "boolean", "constant:1");
    recipe.request.count = 20;
    const StudyResult study = runStudy({settled(recipe)}, {5, 9}, folder.file("t.csv"));
    const auto rows = rowsOf(folder.file("t.csv"));
    REQUIRE(rows.size() == 3);
    for (std::size_t k = 0; k < 2; ++k) {
        VoidsJob alone = recipe;
        alone.seed = k == 0 ? 5 : 9;
        alone.outputs = {"list:" + folder.file("alone.csv")};
        const RunResult run = runVoids(alone);
        CHECK(rows[k + 1][0] == std::to_string(alone.seed));
        CHECK(std::stod(cellOf(rows, k + 1, "bvtv")) == Approx(*run.report.voids->bvtv));
        CHECK(cellOf(rows, k + 1, "count").empty());
        CHECK(rowsOf(folder.file("v" + rows[k + 1][0] + ".csv")) ==
              rowsOf(folder.file("alone.csv")));
    }
    CHECK_THAT(summary(study), Contains("BV/TV") && !Contains("spheres"));
    recipe.outputs = {"list:" + folder.file("v.csv")};
    CHECK_THROWS_WITH(runStudy({settled(recipe)}, {5, 9}, ""), Contains("{seed}"));
}
