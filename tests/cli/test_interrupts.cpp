// Runs that are asked to stop: what is complete is kept, verified, and soon.
#include "cli/recipes.h"
#include "support/paths.h"
#include "support/process.h"
#include "support/temporary_folder.h"
#include "support/tool.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/text.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/study.h"
#include "vdbpack/verify/verify.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <variant>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using test::recipeFor;

namespace {

std::vector<std::string> namesIn(const std::string& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    return names;
}

[[maybe_unused]] double uniform(std::mt19937& random, double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
}

bool isVerified(const std::string& file, const std::string& domain) {
    VerifyRecipe verify;
    verify.pack = file;
    verify.domain.source = domain;
    return runVerify(verify).passed;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG(
    "a pack of a single block stops within the block and keeps the completed spheres", "[pack]",
    ((int Dim), Dim), 2, 3) {
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

TEMPLATE_TEST_CASE_SIG("to be asked whether to stop changes no pack", "[pack]", ((int Dim), Dim), 2,
                       3) {
    const auto domain = ballDomain<Dim>(Dim == 3 ? 25 : 80);
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.threads = GENERATE(1, 2, 3, 8);
    CAPTURE(Dim, options.threads);
    Callbacks callbacks;
    callbacks.cancelled = [] { return false; };
    CHECK(packHash(packSpheres(*domain, options, callbacks).pack) ==
          packHash(packSpheres(*domain, options).pack));
}

TEST_CASE("a pack interrupted in any stage after it is kept, checked and marked", "[run]") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("box:40,40,40", "uniform:1,2");
    recipe.request.method = "boolean";
    recipe.request.radius = "constant:3";
    recipe.outputs = {"solid:" + folder.file("p.stl"), "list:" + folder.file("l.csv"),
                      folder.file("p.csv")};
    recipe.reportFile = folder.file("p.html");
    const std::string stage = GENERATE("voids", "measure", "write");
    CAPTURE(stage);
    bool stop = false;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) { stop = stop || p.stage == stage; };
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
    if (stage == "voids") CHECK(leftOut == 2);
    if (whileWriting) CHECK(leftOut == 0);
    const auto whole = runPack(recipe);
    CHECK_FALSE(whole.report.interrupted);
    if (stage != "voids") CHECK(whole.report.hash == run.report.hash);
}

TEST_CASE("names for what an interrupt leaves are checked before the run", "[run]") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("box:20,20,20", "uniform:1,2");
    recipe.outputs = {folder.file("p.interrupted.csv")};
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

TEST_CASE("an interrupted study leaves the table of a former one", "[run]") {
    const TemporaryFolder folder;
    const std::string table = folder.file("t.csv");
    const PackJob recipe = recipeFor("box:20,20,20", "uniform:1,2");
    runStudy(recipe, {1, 2, 3}, table);
    const auto former = std::filesystem::file_size(table);
    int packs = 0;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) { packs += p.stage == "measure"; };
    callbacks.cancelled = [&] { return packs >= 2; };
    CHECK(runStudy(recipe, {1, 2, 3}, table, callbacks).interrupted);
    CHECK(std::filesystem::file_size(table) == former);
    CHECK(std::filesystem::exists(folder.file("t.interrupted.csv")));
}

TEST_CASE("runs with nothing to keep throw when they are cancelled, and write nothing", "[run]") {
    const TemporaryFolder folder, out;
    PackJob recipe = recipeFor("box:20,20,20", "uniform:1,2");
    recipe.outputs = {folder.file("p.csv")};
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
        VoidsJob voids;
        voids.domain.source = "box:20,20,20";
        voids.request.method = "boolean";
        voids.request.radius = "constant:2";
        voids.request.targetBvtv = 0.5;
        voids.outputs = {out.file("v.vdb")};
        stops(vdbpack::runVoids, settled(voids));
        CarveJob carve;
        carve.pack = folder.file("p.csv");
        carve.domain.source = "box:20,20,20";
        carve.request = voids.request;
        carve.outputs = {out.file("c.csv")};
        stops(vdbpack::runCarve, settled(carve));
        VerifyRecipe verify;
        verify.pack = folder.file("p.csv");
        verify.domain.source = "box:20,20,20";
        stops(runVerify, verify);
        MeasureRecipe measure;
        measure.pack = folder.file("p.csv");
        measure.outputs = {"contacts:" + out.file("c.csv")};
        stops(runMeasure, measure);
        ConvertRecipe convert;
        convert.pack = folder.file("p.csv");
        convert.outputs = {out.file("p.vtp")};
        stops(runConvert, convert);
    }
}

TEST_CASE("an interrupt of the paper's cube stops the packing within half a second", "[.slow]") {
    const TemporaryFolder folder;
    const std::string cube = "box:370,370,370";
    std::mt19937 random(20);
    int kept = 0;
    for (int moment = 0; moment < 20; ++moment) {
        for (const auto& name : namesIn(folder.path())) std::filesystem::remove(folder.file(name));
        const double delay = uniform(random, 0.15, 3.5);
        const int number = moment % 2 == 0 ? SIGINT : SIGTERM;
        test::Process run({"pack", cube, "--radius", "uniform:1,2", "-o", folder.file("p.vdb"),
                           "--preview", folder.file("p.png"), "--report", folder.file("p.json")});
        test::sleepFor(delay);
        const double asked = run.seconds();
        run.signal(number);
        REQUIRE(run.wait() == 130);
        const double ended = run.seconds();
        const std::string reportFile = folder.file("p.interrupted.json");
        if (!std::filesystem::exists(reportFile)) {  // before the first sphere stood
            CHECK(ended - asked < 0.5);
            CHECK(namesIn(folder.path()).empty());
            continue;
        }
        nlohmann::json report;
        std::ifstream(reportFile) >> report;
        if (report["spheres"]["count"] == 0) {  // it alone tells of the run
            CHECK(namesIn(folder.path()).size() == 1);
            continue;
        }
        ++kept;
        const auto& s = report["seconds"];
        const double packed =
            s["mesh"].get<double>() + s["domain"].get<double>() + s["pack"].get<double>();
        CAPTURE(moment, delay, asked, packed, ended);
        CHECK(report["interrupted"] == true);
        CHECK(packed - asked < 0.5);
        // With checking and writing of up to two million spheres.
        CHECK(ended - asked < 5);
        CHECK(isVerified(folder.file("p.interrupted.vdb"), cube));
        CHECK(namesIn(folder.path()).size() == 3);  // and the recipe
    }
    CHECK(kept > 10);
}

TEST_CASE("a second interrupt ends the run at once and leaves no debris", "[.slow]") {
    const TemporaryFolder folder;
    std::mt19937 random(21);
    for (int moment = 0; moment < 20; ++moment) {
        test::Process run({"pack", "box:150,150,150", "--radius", "uniform:1,2", "-o",
                           folder.file("p.csv"), "-o", folder.file("p.vdb"), "--preview",
                           folder.file("p.png")});
        test::sleepFor(uniform(random, 0.05, 1));
        run.signal(SIGINT);
        test::sleepFor(uniform(random, 0, 0.05));
        const double asked = run.seconds();
        run.signal(SIGINT);
        CHECK(run.wait() == 130);
        CHECK(run.seconds() - asked < 0.3);
        for (const auto& name : namesIn(folder.path())) {
            CAPTURE(name);
            CHECK(name.find(".tmp") == std::string::npos);
            if (extensionOf(name) == ".csv" || extensionOf(name) == ".vdb")
                CHECK(isVerified(folder.file(name), "box:150,150,150"));
            std::filesystem::remove(folder.file(name));
        }
    }
}

TEST_CASE("interrupts of other commands on a bone end them at once, with nothing half written",
          "[.slow]") {
    const TemporaryFolder folder;
    const std::string bone = test::kMeshes + "/femur.ply";
    const std::string given = folder.file("given.vdb");
    REQUIRE(test::vdbPack("pack " + bone + " -o " + given + " --quiet").code == 0);
    std::filesystem::remove(folder.file("given.recipe.toml"));
    const std::vector<std::vector<std::string>> commands{
        {"voids", bone, "--voids", "boolean", "--void-radius", "uniform:0.5,1", "--target-bvtv",
         "0.3", "-o", folder.file("v.vdb")},
        {"carve", given, "--domain", bone, "--voids", "boolean", "--void-radius", "constant:1",
         "--target-bvtv", "0.4", "-o", folder.file("v.vdb")},
        {"pack", bone, "--target-count", "200000", "--voids", "boolean", "--void-radius",
         "constant:1", "-o", folder.file("v.vdb"), "--report", folder.file("v.html")},
        {"verify", given, "--domain", bone},
        {"measure", given, "--domain", bone, "--report", folder.file("v.html")},
        {"convert", given, "--domain", bone, "-o", folder.file("v.csv"), "-o",
         "surface:" + folder.file("v.stl"), "--preview", folder.file("v.png")}};
    std::mt19937 random(22);
    for (const auto& command : commands)
        for (int moment = 0; moment < 8; ++moment) {
            test::Process run(command);
            const double delay = uniform(random, 0.03, 1.5);
            test::sleepFor(delay);
            const double asked = run.seconds();
            const int number = moment % 2 == 0 ? SIGINT : SIGTERM;
            run.signal(number);
            const int code = run.wait();
            CAPTURE(command[0], delay, code);
            // Stopped, done, or ended before the program had begun.
            CHECK((code == 130 || code == 0 || code == 128 + number));
            CHECK(run.seconds() - asked < (command[0] == "pack" ? 3.0 : 0.3));
            for (const auto& name : namesIn(folder.path())) {
                CAPTURE(name);
                CHECK(name.find(".tmp") == std::string::npos);
                if (name == "v.vdb" && command[0] == "pack")
                    CHECK(isVerified(folder.file(name), bone));
                if (name != "given.vdb") std::filesystem::remove(folder.file(name));
            }
        }
}
