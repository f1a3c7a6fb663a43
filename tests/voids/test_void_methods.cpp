// Whole runs with voids: pack, voids and carve.
#include "cli/recipes.h"
#include "support/generators.h"
#include "support/mesh_file.h"
#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "voids/stamping.h"
#include "voids/void_recipes.h"

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"
#include "vdbpack/verify/verify.h"
#include "vdbpack/voids/void_list.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;
using test::recipeFor;

namespace {

template <int Dim>
const Pack<Dim>& packIn(const RunResult& run) {
    return std::get<Pack<Dim>>(run.pack);
}

/// Callbacks that keep warnings.
struct Listener {
    std::vector<std::string> warnings;
    Callbacks callbacks;
    Listener() {
        callbacks.warning = [this](const std::string& text) { warnings.push_back(text); };
    }
    bool heard(const std::string& part) const {
        return std::any_of(warnings.begin(), warnings.end(),
                           [&](const std::string& w) { return w.find(part) != std::string::npos; });
    }
};

/// Positions and radii alone, to be found again.
template <int Dim>
std::vector<std::array<double, Dim + 1>> sorted(const std::vector<Sphere<Dim>>& spheres) {
    std::vector<std::array<double, Dim + 1>> all;
    for (const auto& s : spheres) {
        std::array<double, Dim + 1> one;
        for (std::size_t d = 0; d < Dim; ++d) one[d] = s.center.c[d];
        one[Dim] = s.radius;
        all.push_back(one);
    }
    std::sort(all.begin(), all.end());
    return all;
}

const char* const kMethods[] = {"grid",  "overlay",  "concentric", "threshold",
                                "mixed", "ellipses", "boolean",    "foam"};

}  // namespace

TEMPLATE_TEST_CASE_SIG("ellipses leaves no center inside any ellipse", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
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

TEMPLATE_TEST_CASE_SIG("mixed leaves holes without any sphere", "[run][voids]", ((int Dim), Dim), 2,
                       3) {
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

TEMPLATE_TEST_CASE_SIG("thinning takes the share D of the spheres below the shell", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
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
        const double slack = method == std::string("threshold") ? 0.03 : 0.1;
        CHECK(gone / core == Approx(0.3).margin(slack));
    }
}

TEMPLATE_TEST_CASE_SIG("a shell alone tells what is compact and what is not", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
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

TEMPLATE_TEST_CASE_SIG("the shell of a pack with voids stays whole", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
    auto recipe = methodRecipe<Dim>("boolean");
    recipe.request.shell = 4;
    recipe.request.targetBvtv = 0.2;
    auto whole = recipe;
    whole.request = {};
    whole.request.shell = 4;
    const auto all = runPack(whole), run = runPack(recipe);
    CHECK(run.passed);
    const auto compact = [](const RunResult& r) {
        std::vector<Sphere<Dim>> shell;
        for (std::size_t i = 0; i < packIn<Dim>(r).spheres.size(); ++i)
            if (packIn<Dim>(r).region[i] == 0) shell.push_back(packIn<Dim>(r).spheres[i]);
        return sorted(shell);
    };
    const auto before = compact(all), after = compact(run);
    CHECK(before == after);
    CHECK(packIn<Dim>(run).spheres.size() < packIn<Dim>(all).spheres.size());
    // What stays can be reported as connected; the rest can be dropped.
    recipe.request.keepConnected = true;
    const auto kept = runPack(recipe);
    CHECK(kept.report.voids->dropped > 0);
    CHECK(*run.report.voids->spheresAttached < 1);
    CHECK(compact(kept) == before);
}

TEMPLATE_TEST_CASE_SIG("voids of a run are the same for any number of threads",
                       "[run][voids][long]", ((int Dim), Dim), 2, 3) {
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

TEST_CASE("a target is met, or it is said what can be", "[run][voids][long]") {
    struct Case {
        std::string method;
        std::vector<double> met;
        double lowest;  ///< a target beyond reach; 0: none
    };
    const std::vector<Case> cases{{"boolean", {0.15, 0.3}, 0},     {"overlay", {0.6, 0.75}, 0.15},
                                  {"grid", {0.6, 0.75}, 0.3},      {"concentric", {0.15, 0.3}, 0},
                                  {"threshold", {0.15, 0.3}, 0},   {"mixed", {0.75, 0.85}, 0.15},
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

TEST_CASE("BV/TV is that of the level set that is written", "[run][voids]") {
    const TemporaryFolder folder;
    test::writeObj(test::ballMesh(10, 4), folder.file("b.obj"));
    for (const std::string& source : {std::string("box:20,20,20"), folder.file("b.obj")})
        for (const double target : {0.15, 0.3}) {
            CAPTURE(source, target);
            VoidsJob recipe;
            recipe.domain.source = source;
            recipe.request.method = "boolean";
            recipe.request.radius = "constant:0.6";
            recipe.request.shell = 1.5;
            recipe.request.voxelSize = 0.2;
            recipe.request.targetBvtv = target;
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

TEST_CASE("thickness and BV/TV are met together", "[run][voids][.slow]") {
    const TemporaryFolder folder;
    VoidsJob recipe = booleanRecipe(0.15, "constant:0.4", folder.file("v.vdb"));
    recipe.request.targetTbth = 0.25;
    const auto run = runVoids(recipe);
    MeasureRecipe measure;
    measure.pack = folder.file("v.vdb");
    measure.domain.source = "box:10,10,10";
    measure.domain.gridName = "solid";
    const auto measured = runMeasure(measure);
    CHECK(measured.morphometry->solidFraction == Approx(0.15).epsilon(0.05));
    CHECK(measured.morphometry->thickness->mean == Approx(0.25).epsilon(0.05));
    CHECK(*run.report.voids->thickness == Approx(0.25).epsilon(0.05));
}

TEMPLATE_TEST_CASE_SIG("a run stopped while it looks for a target keeps what it has",
                       "[run][voids]", ((int Dim), Dim), 2, 3) {
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

TEMPLATE_TEST_CASE_SIG("a target is met in the plane", "[run][voids]", ((int Dim), Dim), 2) {
    for (const std::string method : {"boolean", "concentric", "threshold", "ellipses"})
        for (const double target : {0.3, 0.6}) {
            CAPTURE(method, target);
            auto recipe = methodRecipe<Dim>(method);
            recipe.request.shell = 4;
            recipe.request.probability.reset();
            recipe.request.deleteFraction.reset();
            recipe.request.targetBvtv = target;
            if (method == "ellipses") recipe.request.radius = "uniform:0.8,1.5";
            CHECK(*runPack(recipe).report.voids->bvtv == Approx(target).margin(0.005));
        }
}

TEMPLATE_TEST_CASE_SIG("spheres that stood before stay whatever the voids", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
    const TemporaryFolder folder;
    std::ofstream(folder.file("s.csv")) << "x,y,z,radius\n0,0,0,2\n3,4,0,1\n";
    for (const char* method : {"boolean", "threshold", "ellipses"}) {
        auto recipe = methodRecipe<Dim>(method);
        CAPTURE(method);
        recipe.existing = folder.file("s.csv");
        if (recipe.request.method == "boolean") recipe.request.targetBvtv = 0.05;
        recipe.request.keepConnected = true;
        const auto run = runPack(recipe);
        REQUIRE(packIn<Dim>(run).spheres.size() > 2);
        CHECK(packIn<Dim>(run).spheres[0].radius == 2);
        CHECK(packIn<Dim>(run).spheres[1].radius == 1);
    }
}

TEMPLATE_TEST_CASE_SIG("steps too large for a target are reported", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
    VoidsJob recipe;
    recipe.domain.source = Dim == 3 ? "box:10,10,10" : "rect:10,10";
    recipe.request.method = "grid";
    recipe.request.cell = "5";
    recipe.request.targetBvtv = 0.9;
    Listener listener;
    const auto run = runVoids(recipe, listener.callbacks);
    CHECK(std::fabs(*run.report.voids->bvtv - 0.9) > 0.005);
    CHECK(listener.heard("`targetBvtv` 0.9:"));
}

TEMPLATE_TEST_CASE_SIG("carve does to a pack what pack does with the same voids", "[run][voids]",
                       ((int Dim), Dim), 2, 3) {
    const TemporaryFolder folder;
    auto whole = packOf<Dim>("");
    whole.outputs = {folder.file("whole.csv")};
    runPack(whole);
    auto recipe = methodRecipe<Dim>("boolean");
    recipe.request.targetBvtv = 0.3;
    recipe.request.shell = 2;
    recipe.outputs = {"list:" + folder.file("l.csv")};
    const auto drawn = runPack(recipe);

    auto listed = packOf<Dim>("list:" + folder.file("l.csv"));
    listed.request.shell = 2;
    listed.request.cull = GENERATE(Cull::center, Cull::touch);
    listed.request.voxelSize = drawn.report.voids->voxelSize;
    const auto direct = runPack(listed);
    if (listed.request.cull == Cull::center) CHECK(direct.report.hash == drawn.report.hash);
    CarveJob carve;
    carve.pack = folder.file("whole.csv");
    carve.domain = listed.domain;
    carve.request = listed.request;
    carve.outputs = {folder.file("carved.csv")};
    const auto carved = runCarve(carve);
    CHECK(carved.passed);
    CHECK(carved.report.hash == direct.report.hash);
    CHECK(sorted(packIn<Dim>(carved).spheres) == sorted(packIn<Dim>(direct).spheres));
    CHECK(carved.report.voids->culled == direct.report.voids->culled);
    CHECK(packIn<Dim>(carved).region == packIn<Dim>(direct).region);
    CHECK(packIn<Dim>(carved).order == packIn<Dim>(direct).order);
    for (const char* method : {"concentric", "threshold", "grid", "overlay"}) {
        CAPTURE(method);
        auto one = methodRecipe<Dim>(method);
        one.request.shell = 2;
        carve.request = one.request;
        carve.outputs.clear();
        CHECK(runCarve(carve).report.hash == runPack(one).report.hash);
    }
}

TEST_CASE("carve takes any pack as it is, and keeps what it does not know", "[run][voids]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("foreign.csv");
    {
        std::ofstream out(file);
        out << "name,z,y,x,radius,material,id\n";
        // A lattice that overlaps, one sphere in ten sticking out.
        int n = 0;
        for (int i = -5; i <= 5; ++i)
            for (int j = -5; j <= 5; ++j)
                for (int k = -5; k <= 5; ++k, ++n)
                    out << "s" << n << "," << k << "," << j << "," << i << ","
                        << (n % 10 == 0 ? 0.7 : 0.4) << "," << n % 3 << "," << 1000 - n % 7 + 10 * n
                        << "\n";
    }
    {
        std::ofstream list(folder.file("l.csv"));
        list << "x,y,z,a,b,ux,uy,uz\n0,0,0,4.5,2.5,0,1,1\n";
    }
    CarveJob carve;
    carve.pack = file;
    carve.domain.source = "box:11,11,11";
    carve.request.method = "list:" + folder.file("l.csv");
    carve.outputs = {folder.file("carved.csv")};
    const auto run = runCarve(carve);
    CHECK(run.passed);
    CHECK(run.report.inputOverlaps > 0);
    CHECK(run.report.inputProtrusions > 0);
    const auto before = readPack(file), after = readPack(folder.file("carved.csv"));
    const auto voids = readVoidList<3>(folder.file("l.csv"));
    std::map<std::array<double, 3>, std::size_t> at;
    for (std::size_t i = 0; i < before.spheres.size(); ++i) at[before.spheres[i].center.c] = i;
    std::size_t kept = 0;
    for (const auto& s : before.spheres) kept += voids[0].signedDistance(s.center) >= 0;
    CHECK(after.spheres.size() == kept);
    CHECK(run.report.voids->culled == before.spheres.size() - kept);
    const auto column = [](const Pack<3>& pack, const std::string& name) {
        for (const auto& c : pack.columns)
            if (c.name == name) return c;
        return Column{};
    };
    const auto names = column(after, "name"), materials = column(after, "material");
    REQUIRE(names.texts.size() == after.spheres.size());
    REQUIRE(materials.numbers.size() == after.spheres.size());
    REQUIRE(after.id.size() == after.spheres.size());
    std::size_t last = 0;
    for (std::size_t n = 0; n < after.spheres.size(); ++n) {
        const std::size_t i = at.at(after.spheres[n].center.c);
        if (n > 0) REQUIRE(i > last);  // in the order they were in
        last = i;
        REQUIRE(names.texts[n] == column(before, "name").texts[i]);
        REQUIRE(materials.numbers[n] == column(before, "material").numbers[i]);
        REQUIRE(after.id[n] == before.id[i]);
        REQUIRE(after.spheres[n].radius == before.spheres[i].radius);
    }
}

TEST_CASE("a solid that voids left can be filled", "[run][voids]") {
    const TemporaryFolder folder;
    VoidsJob voids = booleanRecipe(0.3, "constant:1", folder.file("v.vdb"));
    voids.request.voxelSize = 0.1;
    runVoids(voids);
    PackJob pack = recipeFor(folder.file("v.vdb"), "constant:0.1");
    pack.domain.gridName = "solid";
    const auto run = runPack(pack);
    CHECK(run.passed);
    CHECK(run.report.volume == Approx(300).epsilon(0.03));
    CHECK(run.report.count > 10000);
}
