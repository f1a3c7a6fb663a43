// Runs that are asked to stop: what is complete is kept, verified, and soon.
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/run/run.h"

#include <atomic>
#include <variant>

namespace {

bool isVerified(const std::string& file, const std::string& domain) {
    auto verify = onPack<VerifyRecipe>(file, domain);
    return runVerify(verify).passed;
}

}  // namespace

DIM_TEST_CASE("a pack of a single block stops within the block and keeps the completed spheres") {
    const auto domain = boxDomain<Dim>({{}, Box<Dim>::filled(Dim == 3 ? 60 : 250)});
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.order = Order::wall;
    const auto whole = packSpheres(*domain, options);
    REQUIRE(whole.blocks == 1);
    std::atomic<int> asked{0};
    Callbacks callbacks;
    callbacks.cancelled = [&] { return ++asked > 40; };
    const auto part = packSpheres(*domain, options, callbacks);
    CHECK(part.interrupted);
    REQUIRE(part.pack.spheres.size() > 100);
    REQUIRE(part.pack.spheres.size() < whole.pack.spheres.size());
    // Those that the whole begins with, so without overlap and inside.
    for (std::size_t i = 0; i < part.pack.spheres.size(); ++i)
        REQUIRE(part.pack.spheres[i].center == whole.pack.spheres[i].center);
    CHECK(checkOverlap(part.pack.spheres).pairs == 0);
}

DIM_TEST_CASE("to be asked whether to stop changes no pack") {
    const auto domain = ballDomain<Dim>(Dim == 3 ? 25 : 80);
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.threads = GENERATE(1, 2, 3, 8);
    CAPTURE(Dim, options.threads);
    Callbacks callbacks;
    callbacks.cancelled = [] { return false; };
    CHECK(packHash(packSpheres(*domain, options, callbacks).pack) ==
          packHash(packSpheres(*domain, options).pack));
}

TEST_CASE("a pack interrupted in any stage after it is kept, checked and marked") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("box:40,40,40", "uniform:1,2");
    setVoids(recipe.request, "boolean", "constant:3");
    recipe.outputs = {"solid:" + folder.file("p.stl"), "list:" + folder.file("l.csv"),
                      folder.file("p.csv")};
    recipe.reportFile = folder.file("p.html");
    const std::string stage = GENERATE("densify", "voids", "measure", "write");
    CAPTURE(stage);
    if (stage == "densify") recipe.densify.fraction = 0.65;
    bool stop = false;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) { stop = stop || p.stage.rfind(stage, 0) == 0; };
    callbacks.cancelled = [&] { return stop; };
    const auto run = runPack(recipe, callbacks);
    // Once the files are written, they are whole, and so is the report: the picture alone is left
    // out.
    const bool whileWriting = stage == "write";
    CHECK(run.report.interrupted == !whileWriting);
    CHECK(run.passed);
    CHECK(run.report.count > 500);
    CHECK(run.report.overlap->pairs == 0);
    CHECK(run.picture.png.empty());
    const std::string mark = whileWriting ? "" : ".interrupted";
    CHECK(isVerified(folder.file("p" + mark + ".csv"), recipe.domain.source));
    CHECK(std::filesystem::exists(folder.file("p" + mark + ".html")));
    // Voids that are not complete are left out, with a warning, and nothing else is.
    const auto names = namesIn(folder.path());
    for (const auto& name : names)
        CHECK((name.find(".interrupted.") == std::string::npos) == whileWriting);
    const auto& warnings = run.report.warnings;
    const auto leftOut = std::count_if(warnings.begin(), warnings.end(), [](const auto& w) {
        return w.find("is not written") != std::string::npos;
    });
    CHECK(names.size() + static_cast<std::size_t>(leftOut) == 4);
    if (stage == "voids" || stage == "densify") CHECK(leftOut == 2);
    if (whileWriting) CHECK(leftOut == 0);
    recipe.densify.fraction = 0;
    if (stage == "densify") recipe.request = {}, recipe.outputs = {};  // the pack of the front
    const auto whole = runPack(recipe);
    CHECK_FALSE(whole.report.interrupted);
    if (stage != "voids") CHECK(whole.report.hash == run.report.hash);
}

TEST_CASE("names for what an interrupt leaves are checked before the run") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("box:20,20,20", "uniform:1,2", folder.file("p.interrupted.csv"));
    runPack(recipe);
    recipe.existing = folder.file("p.interrupted.csv");
    recipe.radius = SizeRequest::parse("constant:0.5");
    recipe.outputs = {folder.file("p.csv")};
    CHECK_THROWS_AS(runPack(recipe), ParameterError);
    CHECK(namesIn(folder.path()).size() == 1);
    // Too long a name is cut.
    const std::string longName = interruptedName(folder.file(std::string(245, 'n') + ".csv"));
    CHECK(std::filesystem::path(longName).filename().string().size() == 255);
    CHECK(longName.substr(longName.size() - 16) == ".interrupted.csv");
}

TEST_CASE("an interrupted study keeps the complete rows, and leaves the table of a former one") {
    const TemporaryFolder folder;
    const std::string table = folder.file("t.csv");
    const PackJob recipe = recipeFor("box:20,20,20", "uniform:1,2");
    runStudy({recipe}, {1, 2, 3}, table);
    const auto former = std::filesystem::file_size(table);
    int packs = 0;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) { packs += p.stage == "measure"; };
    callbacks.cancelled = [&] { return packs >= 2; };
    const auto study = runStudy({recipe}, {1, 2, 3}, table, callbacks);
    CHECK(study.interrupted);
    CHECK(study.reports.size() == 1);
    CHECK(std::filesystem::file_size(table) == former);
    const std::string rows = contentOf(folder.file("t.interrupted.csv"));
    CHECK(std::count(rows.begin(), rows.end(), '\n') == 2);
}

TEST_CASE("runs with nothing to keep throw when they are cancelled, and write nothing") {
    const TemporaryFolder folder, out;
    PackJob recipe = recipeFor("box:20,20,20", "uniform:1,2", folder.file("p.csv"));
    runPack(recipe);
    // In the first, second, ... place where they ask.
    for (int patience = 0; patience < 6; ++patience) {
        CAPTURE(patience);
        std::atomic<int> asked{0};
        Callbacks callbacks;
        callbacks.cancelled = [&] { return ++asked > patience; };
        const auto stops = [&](auto&& run, auto given) {
            asked = 0;
            try {
                run(given, callbacks);
                CHECK(asked <= patience);
            } catch (const Interrupted&) {
                CHECK(asked > patience);
                CHECK(namesIn(out.path()).empty());
            }
            for (const auto& name : namesIn(out.path())) std::filesystem::remove(out.file(name));
        };
        auto voids = voidsIn("box:20,20,20", out.file("v.vdb"));
        setVoids(voids.request, "boolean", "constant:2", 0.5);
        stops(vdbpack::runVoids, settled(voids));
        auto carve = onPack<CarveJob>(folder.file("p.csv"), "box:20,20,20", out.file("c.csv"));
        carve.request = voids.request;
        stops(vdbpack::runCarve, settled(carve));
        auto verify = onPack<VerifyRecipe>(folder.file("p.csv"), "box:20,20,20");
        stops(runVerify, verify);
        auto measure =
            onPack<MeasureRecipe>(folder.file("p.csv"), {}, "contacts:" + out.file("c.csv"));
        stops(runMeasure, measure);
        auto convert = onPack<ConvertRecipe>(folder.file("p.csv"), {}, out.file("p.vtp"));
        stops(runConvert, convert);
    }
}
