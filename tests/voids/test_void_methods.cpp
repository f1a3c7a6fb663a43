// Whole runs with voids: pack, voids and carve.
#include "support/generators.h"
#include "support/mesh_file.h"
#include "support/test.h"
#include "voids/stamping.h"
#include "voids/void_recipes.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/voids/void_list.h"

namespace {

const char* const kMethods[] = {"grid",  "overlay",  "concentric", "threshold",
                                "mixed", "ellipses", "boolean",    "foam"};

}  // namespace

DIM_TEST_CASE("ellipses leaves no center inside any ellipse") {
    const TemporaryFolder folder;
    auto recipe = methodRecipe<Dim>("ellipses");
    recipe.request.shell = GENERATE(0.0, 4.0);
    recipe.request.aspect = "uniform:1,3";
    recipe.outputs = {"list:" + folder.file("l.csv")};
    const auto run = runPack(recipe);
    CHECK(run.passed);
    const auto voids = readVoidList<Dim>(folder.file("l.csv"));
    REQUIRE(voids.size() == run.report.voids->count);
    REQUIRE(voids.size() > 10);
    CHECK(run.report.voids->culled > 30);
    const auto& pack = packIn<Dim>(run);
    REQUIRE(pack.spheres.size() > 1000);
    std::size_t inside = 0, inShell = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto& s = pack.spheres[i];
        REQUIRE(s.radius <= 1);  // no hole is left
        bool within = false;
        for (const auto& e : voids) within = within || e.contains(s.center);
        (pack.region[i] == 1 ? inside : inShell) += within;
        // Holes took part in the front: nothing else stands in them.
        for (const auto& e : voids)
            if (e.b + s.radius > length(e.center - s.center) + 1e-6)
                FAIL("a sphere stands in a hole");
    }
    CHECK(inside == 0);
    if (recipe.request.shell > 0)
        CHECK(inShell > 0);  // ellipses stick into the shell, which stays whole
    else
        CHECK(inShell == 0);
}

DIM_TEST_CASE("mixed leaves holes without any sphere") {
    const TemporaryFolder folder;
    auto recipe = methodRecipe<Dim>("mixed");
    recipe.request.radius = "uniform:3,5";
    recipe.outputs = {"list:" + folder.file("l.csv")};
    const auto run = runPack(recipe);
    CHECK(run.passed);
    const auto holes = readVoidList<Dim>(folder.file("l.csv"));
    REQUIRE(holes.size() > 5);
    for (const auto& hole : holes) {
        CHECK(hole.a == hole.b);
        CHECK(hole.b >= 3);
        CHECK(hole.b <= 5);
        for (const auto& s : packIn<Dim>(run).spheres) {
            REQUIRE(s.radius <= 1);
            REQUIRE(length(s.center - hole.center) > hole.b + s.radius - 1e-6);
        }
    }
    // As many of all as were requested, as long as there is room.
    CHECK(*run.report.voids->reachedShare < 0.05);
    for (std::size_t i = 0; i < packIn<Dim>(run).order.size(); ++i)
        REQUIRE(packIn<Dim>(run).order[i] == static_cast<std::int64_t>(i));
}

DIM_TEST_CASE("thinning takes the share D of the spheres below the shell") {
    for (const char* method : {"threshold", "concentric"}) {
        auto recipe = methodRecipe<Dim>(method);
        recipe.request.shell = 4;
        CAPTURE(Dim, method);
        auto whole = recipe;
        whole.request = {};
        whole.request.shell = 4;
        const auto all = runPack(whole), run = runPack(recipe);
        CHECK(run.passed);
        const auto& before = packIn<Dim>(all);
        const auto& after = packIn<Dim>(run);
        const auto shellOf = [](const Pack<Dim>& pack) {
            std::vector<Sphere<Dim>> shell;
            for (std::size_t i = 0; i < pack.spheres.size(); ++i)
                if (pack.region[i] == 0) shell.push_back(pack.spheres[i]);
            return shell;
        };
        CHECK(sorted(shellOf(before)) == sorted(shellOf(after)));
        const double core = static_cast<double>(before.spheres.size() - shellOf(before).size());
        const double gone = static_cast<double>(run.report.voids->culled);
        CHECK(core > 500);
        CHECK(gone == static_cast<double>(before.spheres.size() - after.spheres.size()));
        // The front places small ones more often than they are drawn: not quite uniform.
        const double slack = method == std::string("threshold") ? 0.035 : 0.1;
        CHECK(gone / core == Approx(0.3).margin(slack));
    }
}

DIM_TEST_CASE("a shell alone tells what is compact and what is not") {
    auto recipe = packOf<Dim>("");
    auto plain = recipe;
    recipe.request.shell = 5;
    Listener listener;
    const auto run = runPack(recipe, listener.callbacks), none = runPack(plain);
    CHECK(run.report.hash == none.report.hash);
    const auto& pack = packIn<Dim>(run);
    const double half = Dim == 3 ? 12 : 50;
    std::size_t cortical = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        double depth = half;
        for (int d = 0; d < Dim; ++d)
            depth = std::min(depth, half - std::fabs(pack.spheres[i].center[d]));
        REQUIRE(pack.region[i] == (depth > 5 ? 1 : 0));
        cortical += pack.region[i] == 0;
    }
    CHECK(cortical > 100);
    CHECK(run.report.voids->cortical == cortical);
    CHECK_FALSE(run.report.voids->bvtv.has_value());
    CHECK(*run.report.voids->across > 3);
    CHECK_FALSE(listener.heard("the shell of"));
    recipe.request.shell = 2;
    runPack(recipe, listener.callbacks);
    CHECK(listener.heard("the shell of"));
    for (const std::int32_t region : packIn<Dim>(none).region) REQUIRE(region == 0);
}

TEMPLATE_TEST_CASE_SIG("voids of a run are the same for any number of threads", "[long]",
                       ((int Dim), Dim), 2, 3) {
    const TemporaryFolder folder;
    for (const std::string method : kMethods) {
        CAPTURE(Dim, method);
        auto recipe = methodRecipe<Dim>(method);
        recipe.request.shell = 3;
        const bool thins = method == "concentric" || method == "threshold";
        if (method == "boolean" || thins) {
            recipe.request.targetBvtv = 0.4;
            recipe.request.deleteFraction.reset();
        }
        if (!thins) recipe.outputs = {"list:" + folder.file("l.csv")};
        std::string list;
        std::optional<std::uint64_t> hash;
        for (const int threads : {1, 2, 3, 8}) {
            recipe.threads = threads;
            const auto run = runPack(recipe);
            // Of mixed nothing but the holes themselves goes.
            CHECK((run.report.voids->culled > 0) == (method != "mixed"));
            if (!hash) {
                hash = run.report.hash;
                if (!thins) list = contentOf(folder.file("l.csv"));
                continue;
            }
            CHECK(run.report.hash == *hash);
            if (!thins) CHECK(contentOf(folder.file("l.csv")) == list);
        }
        recipe.seed = 2;
        CHECK(runPack(recipe).report.hash != *hash);
    }
}

TEST_CASE("a target is met, or it is said what can be", "[long]") {
    struct Case {
        std::string method;
        std::vector<double> met;
        double lowest;  ///< a target beyond reach; 0: none
    };
    const std::vector<Case> cases{{"boolean", {0.15, 0.3}, 0},     {"overlay", {0.6, 0.75}, 0.15},
                                  {"grid", {0.6, 0.75}, 0.3},      {"concentric", {0.15, 0.3}, 0},
                                  {"threshold", {0.15, 0.3}, 0},   {"mixed", {0.8, 0.85}, 0.15},
                                  {"ellipses", {0.6, 0.75}, 0.15}, {"foam", {0.15, 0.5}, 0}};
    for (const Case& c : cases) {
        auto recipe = methodRecipe<3>(c.method);
        recipe.domain.source = "box:30,30,30";
        recipe.request.shell = 3;
        recipe.request.probability.reset();
        recipe.request.deleteFraction.reset();
        if (c.method == "grid") recipe.request.cell = "3";
        if (c.method == "ellipses") recipe.request.radius = "uniform:1,2";
        if (c.method == "overlay") recipe.request.aspect = "constant:1.1";
        for (const double target : c.met) {
            CAPTURE(c.method, target);
            recipe.request.targetBvtv = target;
            Listener listener;
            const auto run = runPack(recipe, listener.callbacks);
            CHECK(*run.report.voids->bvtv == Approx(target).margin(0.005));
            CHECK_FALSE(listener.heard("`targetBvtv`"));
        }
        if (c.lowest > 0) {
            CAPTURE(c.method);
            recipe.request.targetBvtv = c.lowest;
            CHECK_THAT(messageOf<ParameterError>([&] { runPack(recipe); }),
                       Contains("`targetBvtv`") && Contains(c.method) && Contains(" 0."));
        }
    }
}

TEST_CASE("BV/TV is that of the level set that is written") {
    const TemporaryFolder folder;
    writeObj(ballMesh(10, 4), folder.file("b.obj"));
    for (const std::string& source : {std::string("box:20,20,20"), folder.file("b.obj")})
        for (const double target : {0.15, 0.3}) {
            CAPTURE(source, target);
            auto recipe = voidsIn(source);
            setVoids(recipe.request, "boolean", "constant:0.6", target);
            recipe.request.shell = 1.5;
            recipe.request.voxelSize = 0.2;
            recipe.outputs = {folder.file("v.vdb"), "list:" + folder.file("v.csv")};
            const auto run = runVoids(recipe);
            CHECK(*run.report.voids->bvtv == Approx(target).margin(0.001));
            // Counted again, voxel by voxel.
            const auto image = sampleLevelSet(*levelSetGrid(folder.file("v.vdb"), "solid", 1),
                                              Box<3>{{{-10, -10, -10}}, {{10, 10, 10}}});
            double core = 0, left = 0, shell = 0, whole = 0;
            for (std::size_t v = 0; v < image.voxels(); ++v) {
                const Vec<3> x = centerOf(image, v);
                double depth = 10 - length(x);
                if (source == "box:20,20,20")
                    depth = 10 - std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])});
                (depth > 1.5 ? core : shell) += depth > 0.1;
                (depth > 1.5 ? left : whole) += depth > 0.1 && image.distance[v] < 0;
            }
            CHECK(left / core == Approx(target).margin(0.005));
            CHECK(whole == shell);
            // The list makes the same again.
            VoidsJob again = recipe;
            again.request = {};
            again.request.method = "list:" + folder.file("v.csv");
            again.request.shell = 1.5;
            again.request.voxelSize = run.report.voids->voxelSize;
            again.outputs = {"list:" + folder.file("w.csv")};
            const auto listed = runVoids(again);
            CHECK(*listed.report.voids->bvtv == *run.report.voids->bvtv);
            CHECK(contentOf(folder.file("w.csv")) == contentOf(folder.file("v.csv")));
        }
}

TEST_CASE("thickness and BV/TV are met together", "[.slow]") {
    const TemporaryFolder folder;
    VoidsJob recipe = booleanRecipe(0.15, "constant:0.4", folder.file("v.vdb"));
    recipe.request.targetTbth = 0.25;
    const auto run = runVoids(recipe);
    auto measure = onPack<MeasureRecipe>(folder.file("v.vdb"), "box:10,10,10");
    measure.domain.gridName = "solid";
    const auto measured = runMeasure(measure);
    CHECK(measured.morphometry->solidFraction == Approx(0.15).epsilon(0.05));
    CHECK(measured.morphometry->thickness->mean == Approx(0.25).epsilon(0.05));
    CHECK(*run.report.voids->thickness == Approx(0.25).epsilon(0.05));
}

DIM_TEST_CASE("a run stopped while it looks for a target keeps what it has") {
    auto recipe = methodRecipe<Dim>("ellipses");
    recipe.domain.source = Dim == 3 ? "box:60,60,60" : "rect:400,400";
    recipe.request.probability.reset();
    recipe.request.targetBvtv = 0.7;
    Callbacks callbacks;
    bool stop = false;
    callbacks.cancelled = [&] { return stop; };
    callbacks.progress = [&](const Progress& p) { stop = stop || p.count > 5000; };
    const auto run = runPack(recipe, callbacks);
    CHECK(run.report.interrupted);
    CHECK(run.passed);
}

TEST_CASE("a target is met in the plane") {
    const auto [method, target] = GENERATE(table<std::string, double>(
        {{"boolean", 0.3}, {"concentric", 0.6}, {"threshold", 0.3}, {"ellipses", 0.6}}));
    CAPTURE(method);
    auto recipe = methodRecipe<2>(method);
    recipe.request.shell = 4;
    recipe.request.probability.reset();
    recipe.request.deleteFraction.reset();
    recipe.request.targetBvtv = target;
    if (method == "ellipses") recipe.request.radius = "uniform:0.8,1.5";
    CHECK(*runPack(recipe).report.voids->bvtv == Approx(target).margin(0.005));
}

DIM_TEST_CASE("steps too large for a target are reported") {
    auto recipe = voidsIn(Dim == 3 ? "box:10,10,10" : "rect:10,10");
    setVoids(recipe.request, "grid", "", 0.9);
    recipe.request.cell = "5";
    Listener listener;
    const auto run = runVoids(recipe, listener.callbacks);
    CHECK(std::fabs(*run.report.voids->bvtv - 0.9) > 0.005);
    CHECK(listener.heard("`targetBvtv` 0.9:"));
}
