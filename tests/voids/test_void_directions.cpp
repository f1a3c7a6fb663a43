// Directions of voids in whole runs, found again in the solid that is written.
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/voids/void_list.h"

namespace {

/// Anisotropy of the solid in a part of a level set.
Anisotropy fabricIn(const std::string& file, const Box<3>& box) {
    const auto grid = levelSetGrid(file, "solid", 1);
    return measureMorphometry(sampleLevelSet(*grid, box)).anisotropy.value();
}

double degreesBetween(const Vec<3>& a, const Vec<3>& b) {
    return std::acos(std::min(1.0, std::fabs(dot(a, b)))) * 180 / kPi;
}

VoidsJob orientedVoids(double side, const std::string& file) {
    VoidsJob recipe;
    const std::string s = std::to_string(side);
    recipe.domain.source = "box:" + s + "," + s + "," + s;
    setVoids(recipe.request, "boolean", "constant:0.5", 0.25);
    recipe.request.aspect = "constant:3";
    recipe.request.voxelSize = 0.2;
    recipe.outputs = {file};
    return recipe;
}

}  // namespace

TEST_CASE("the direction wanted is the direction found", "[long]") {
    const TemporaryFolder folder;
    auto recipe = orientedVoids(16, folder.file("v.vdb"));
    const Box<3> box{{{-8, -8, -8}}, {{8, 8, 8}}};
    const auto seed = GENERATE(1u, 2u);
    recipe.seed = seed;
    recipe.request.orientation.axis = VoidAxis::parse("0,0,1");
    runVoids(recipe);
    const auto along = fabricIn(folder.file("v.vdb"), box);
    INFO("DA " << along.degree << ", " << degreesBetween(along.axes[0], {{0, 0, 1}}) << " degrees");
    CHECK(degreesBetween(along.axes[0], {{0, 0, 1}}) < 5);
    CHECK(along.degree > 0.3);
    recipe.request.orientation.axis = VoidAxis::parse("1,-2,0.5");
    runVoids(recipe);
    CHECK(degreesBetween(fabricIn(folder.file("v.vdb"), box).axes[0],
                         normalized(Vec<3>{{1, -2, 0.5}})) < 5);
    recipe.request.orientation = {};
    recipe.request.orientation.angles = VoidAngles::parse("isotropic");
    runVoids(recipe);
    const auto none = fabricIn(folder.file("v.vdb"), box);
    INFO("isotropic: DA " << none.degree);
    CHECK(none.degree < 0.15);
}

TEST_CASE("voids follow a field that turns, whatever its signs") {
    const TemporaryFolder folder;
    const double side = 24;
    const auto direction = [&](double x) {
        const double angle = 0.5 * kPi * (x / side + 0.5);
        return Vec<3>{{0, std::sin(angle), std::cos(angle)}};
    };
    RandomStream random(81, 1);
    for (const bool flip : {false, true}) {
        std::ofstream out(folder.file(flip ? "flipped.csv" : "plain.csv"));
        out.precision(17);
        out << "x,y,z,ux,uy,uz\n";
        for (int i = 0; i <= 12; ++i)
            for (int j = 0; j <= 4; ++j)
                for (int k = 0; k <= 4; ++k) {
                    const double x = side * (i / 12.0 - 0.5);
                    const Vec<3> u = direction(x) * (flip && random.uniform() < 0.5 ? -1.0 : 1.0);
                    out << x << "," << side * (j / 4.0 - 0.5) << "," << side * (k / 4.0 - 0.5)
                        << "," << u[0] << "," << u[1] << "," << u[2] << "\n";
                }
    }
    auto recipe = orientedVoids(side, folder.file("v.vdb"));
    recipe.outputs.push_back("list:" + folder.file("plain.list.csv"));
    recipe.request.orientation.field = folder.file("plain.csv");
    runVoids(recipe);
    for (const double at : {-9.0, 0.0, 9.0}) {
        const auto fabric =
            fabricIn(folder.file("v.vdb"), {{{at - 3, -12, -12}}, {{at + 3, 12, 12}}});
        CAPTURE(at, fabric.degree);
        INFO(degreesBetween(fabric.axes[0], direction(at)) << " degrees");
        CHECK(degreesBetween(fabric.axes[0], direction(at)) < 10);
        CHECK(fabric.degree > 0.25);
    }
    recipe.request.orientation.field = folder.file("flipped.csv");
    recipe.outputs = {"list:" + folder.file("flipped.list.csv")};
    runVoids(recipe);
    const auto plain = readVoidList<3>(folder.file("plain.list.csv")),
               flipped = readVoidList<3>(folder.file("flipped.list.csv"));
    REQUIRE(plain.size() == flipped.size());
    REQUIRE(plain.size() > 1000);
    CHECK(contentOf(folder.file("plain.list.csv")) == contentOf(folder.file("flipped.list.csv")));
    for (std::size_t i = 0; i < plain.size(); ++i) {
        REQUIRE(plain[i].center == flipped[i].center);
        REQUIRE(degreesBetween(plain[i].axis, flipped[i].axis) < 1e-5);
    }
}
