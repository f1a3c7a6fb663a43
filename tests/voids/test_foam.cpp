// Voids of an open-cell foam: runs with `voids` foam.
#include "support/jobs.h"
#include "support/test.h"
#include "voids/turning.h"

#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>

namespace {

VoidsJob foam(const std::string& source, double bvtv, const std::string& output) {
    auto recipe = voidsIn(source, output);
    setVoids(recipe.request, "foam", "uniform:0.25,0.5", bvtv);
    return recipe;
}

}  // namespace

TEST_CASE("the struts of a foam are connected") {
    const TemporaryFolder folder;
    auto recipe = foam("box:4,4,4", GENERATE(0.06, 0.1, 0.2, 0.45), folder.file("v.vdb"));
    const auto made = runVoids(recipe);
    CHECK(*made.report.voids->bvtv == Approx(*recipe.request.targetBvtv).margin(0.002));
    CHECK(*made.report.voids->solidAttached > 0.995);
    // Voids at random leave pieces of as much bone.
    recipe.request.method = "boolean";
    if (*recipe.request.targetBvtv < 0.15)
        CHECK(*runVoids(recipe).report.voids->solidAttached < *made.report.voids->solidAttached);
}

TEST_CASE("the cells of a foam are as long as they are asked to be", "[long]") {
    const TemporaryFolder folder;
    const double aspect = GENERATE(1.0, 1.4, 2.0);
    auto recipe = foam("box:4,4,4", 0.2, folder.file("v.vdb"));
    recipe.request.aspect = "constant:" + std::to_string(aspect);
    recipe.request.orientation.axis = VoidAxis::parse("1,1,0");
    runVoids(recipe);
    auto measure = onPack<MeasureRecipe>(folder.file("v.vdb"), "box:4,4,4");
    const auto measured = runMeasure(measure);
    REQUIRE(measured.morphometry->anisotropy);
    const auto& anisotropy = *measured.morphometry->anisotropy;
    // Intercepts are as long as the cells.
    CHECK(*anisotropy.ratio == Approx(aspect).epsilon(0.12));
    if (aspect > 1.2)
        CHECK(std::fabs(dot(anisotropy.axes[0], Vec<3>{{std::sqrt(0.5), std::sqrt(0.5), 0}})) >
              0.98);
}

TEST_CASE("the voids of a foam touch before they are dilated") {
    const TemporaryFolder folder;
    auto recipe = foam("box:4,4,4", 0.2, "list:" + folder.file("l.csv"));
    recipe.request.orientation.axis = VoidAxis::parse("0,0,1");
    recipe.request.aspect = "constant:1.5";
    recipe.request.jitter = 0;
    const double factor = *runVoids(recipe).report.voids->amount;
    CHECK(factor > 1.02);
    auto voids = readVoidList<3>(folder.file("l.csv"));
    REQUIRE(voids.size() > 200);
    std::size_t touching = 0;
    for (auto& e : voids) {
        CHECK(e.a == Approx(1.5 * e.b));
        e.center[2] /= 1.5;
    }
    for (std::size_t i = 0; i < voids.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const double apart =
                length(voids[i].center - voids[j].center) - (voids[i].b + voids[j].b) / factor;
            REQUIRE(apart > -1e-5);
            touching += apart < 0.02;
        }
    CHECK(touching > 2 * voids.size());
}

TEST_CASE("a list of voids, their blend and struts make the same foam again") {
    const TemporaryFolder folder;
    auto recipe = foam("box:3,3,3", 0.25, "list:" + folder.file("l.csv"));
    recipe.request.blend = 0.05;
    recipe.request.strut = 0.1;
    recipe.request.strutShare = 0.5;
    const auto first = runVoids(recipe).report.voids;
    recipe.request.method = "list:" + folder.file("l.csv");
    recipe.request.radius.clear();
    recipe.request.targetBvtv.reset();
    recipe.request.voxelSize = first->voxelSize;
    recipe.outputs = {folder.file("v.vdb")};
    CHECK(*runVoids(recipe).report.voids->bvtv == Approx(*first->bvtv).margin(1e-4));
    // Without the blend, walls between the voids are left; without struts, there is less.
    recipe.request.blend.reset();
    CHECK(*runVoids(recipe).report.voids->bvtv > *first->bvtv + 0.01);
    recipe.request.strut.reset();
    recipe.request.strutShare.reset();
    recipe.request.blend = 0.05;
    CHECK(*runVoids(recipe).report.voids->bvtv < *first->bvtv - 0.003);
}

TEST_CASE("the cells of a foam follow a field of directions") {
    const TemporaryFolder folder;
    std::string field = "x,y,z,ux,uy,uz\n";
    for (int k = 0; k < 11 * 11 * 11; ++k) {
        const Vec<3> x{{k % 11 * 0.5 - 2.5, k / 11 % 11 * 0.5 - 2.5, k / 121 * 0.5 - 2.5}};
        const Vec<3> u = turning(x, 5);
        field += fmt::format("{},{},{},{},{},{}\n", x[0], x[1], x[2], u[0], u[1], u[2]);
    }
    putContent(folder.file("f.csv"), field);
    auto recipe = foam("box:4,4,4", 0.2, "list:" + folder.file("l.csv"));
    recipe.request.orientation.field = folder.file("f.csv");
    recipe.request.aspect = "constant:2";
    const auto run = runVoids(recipe);
    CHECK(*run.report.voids->bvtv == Approx(0.2).margin(0.003));
    CHECK(*run.report.voids->solidAttached > 0.95);
    for (const auto& e : readVoidList<3>(folder.file("l.csv")))
        if (std::fabs(e.center[0]) < 2) REQUIRE(degreesBetween(e.axis, turning(e.center, 5)) < 8);
}

TEST_CASE("a foam in the plane, and in a bone with a shell") {
    const TemporaryFolder folder;
    auto flat = foam("disc:6", 0.3, "list:" + folder.file("l.csv"));
    flat.request.orientation.axis = VoidAxis::parse("1,0");
    CHECK(*runVoids(flat).report.voids->bvtv == Approx(0.3).margin(0.003));
    auto shelled = foam("ball:3", 0.25, folder.file("v.vdb"));
    shelled.request.shell = 0.5;
    shelled.request.keepConnected = true;
    const auto run = runVoids(shelled);
    CHECK(*run.report.voids->bvtv == Approx(0.25).margin(0.003));
    CHECK(*run.report.voids->solidAttached > 0.99);
}
