// Shells measured from the outer surface alone.
#include "support/generators.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/test.h"

#include "vdbpack/domain/core_volume.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/run/run.h"

namespace {

constexpr double kOuter = 10, kInner = 4, kShell = 2;

double ball(double radius) {
    return 4 * kPi / 3 * std::pow(radius, 3);
}

/// A ball around the origin with a cavity.
std::string hollowBall(const TemporaryFolder& folder, double cavity = kInner) {
    const std::string file = folder.file("hollow.obj");
    writeObj(hollowBallMesh(kOuter, cavity, 4), file);
    return file;
}

DomainRecipe fromOuter(const std::string& file) {
    DomainRecipe recipe;
    recipe.source = file;
    recipe.shellFrom = ShellFrom::outer;
    return recipe;
}

PackJob porous(const std::string& file) {
    PackJob recipe = recipeFor(file, "uniform:0.3,0.6");
    recipe.domain = fromOuter(file);
    setVoids(recipe.request, "boolean", "constant:0.9", 0.5);
    recipe.request.shell = kShell;
    return recipe;
}

/// Spheres at most `below` the outer surface whose region is not 0, and deeper ones whose is.
std::size_t wronglyLabelled(const RunResult& run, double below) {
    const auto& pack = std::get<Pack<3>>(run.pack);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const double depth = kOuter - length(pack.spheres[i].center);
        // The mesh lies within the ball.
        if (std::fabs(depth - below) > 0.05) wrong += (depth > below) != (pack.region[i] == 1);
    }
    return wrong;
}

}  // namespace

TEST_CASE("a shell measured from the outer surface encloses a core that ends at the cavity") {
    const TemporaryFolder folder;
    // The cavity lies in the core; it reaches into the shell.
    for (const double cavity : {kInner, 9.0}) {
        const auto built = DomainSource(fromOuter(hollowBall(folder, cavity))).build(0.3, kShell);
        const Domain<3>& domain = *built.space;
        const double walls = domain.volumeDeeperThan(kShell);
        const double expected = std::max(0.0, ball(kOuter - kShell) - ball(cavity));
        CHECK(coreVolume(domain, kShell) == Approx(expected).epsilon(0.015).margin(2));
        CHECK(walls < coreVolume(domain, kShell) + 2);
        CHECK(coreVolume(domain, 0) == domain.volume());
    }
}

TEST_CASE("clips do not count as surface where a shell is measured from the outer surface") {
    const TemporaryFolder folder;
    DomainRecipe recipe = fromOuter(hollowBall(folder));
    recipe.clips = {parseClip("plane:0,0,1,0")};
    const auto built = DomainSource(recipe).build(0.3, kShell);
    const double expected = 0.5 * (ball(kOuter - kShell) - ball(kInner));
    CHECK(coreVolume(*built.space, kShell) == Approx(expected).epsilon(0.015));

    DomainRecipe shape;
    shape.source = "cylinder:5,20";
    shape.shellFrom = ShellFrom::outer;
    shape.clips = {parseClip("plane:0,0,1,0")};
    const auto half = DomainSource(shape).build(0.3, 1);
    CHECK(coreVolume(*half.space, 1) == Approx(kPi * 16 * 9).epsilon(0.01));

    recipe.clips.clear();
    recipe.slice = 0;
    const auto plane = DomainSource(recipe).build(0.3, kShell);
    CHECK(coreVolume(*plane.plane, kShell) ==
          Approx(kPi * (std::pow(kOuter - kShell, 2) - kInner * kInner)).epsilon(0.015));
}

TEST_CASE("voids reach the walls of cavities where the shell is measured from the outer surface") {
    const TemporaryFolder folder;
    const PackJob recipe = porous(hollowBall(folder));
    for (const Fill fill : {Fill::domain, Fill::solid}) {
        PackJob filled = recipe;
        filled.request.fill = fill;
        const RunResult run = runPack(filled);
        REQUIRE(run.passed);
        REQUIRE(run.report.count > 1000);
        CHECK(run.report.voids->bvtv.value() == Approx(0.5).margin(0.01));
        CHECK(run.report.voids->totalVolume ==
              Approx(ball(kOuter - kShell) - ball(kInner)).epsilon(0.015));
        CHECK(wronglyLabelled(run, kShell) == 0);
    }
}

TEST_CASE("voids that are packed behind a shell may be larger than the spheres' own field") {
    const TemporaryFolder folder;
    writeObj(ballMesh(10, 4), folder.file("ball.obj"));
    PackJob recipe = recipeFor(folder.file("ball.obj"), "uniform:0.4,0.8");
    setVoids(recipe.request, "overlay", {}, 0.95);
    recipe.request.shell = 2;
    const RunResult run = runPack(recipe);
    CHECK(run.passed);
    CHECK(run.report.voids->bvtv.value() == Approx(0.95).margin(0.02));
}

TEST_CASE("a solid is attached where it reaches the outer shell, not the wall of a cavity") {
    const TemporaryFolder folder;
    // Balls side by side on a sphere part the solid around the cavity from the rest.
    const std::string list = folder.file("voids.csv");
    std::ofstream out(list);
    out << "x,y,z,a,b,ux,uy,uz\n";
    constexpr int kVoids = 400;
    for (int i = 0; i < kVoids; ++i) {
        const double z = 1 - (2 * i + 1.0) / kVoids, turn = i * kPi * (3 - std::sqrt(5.0));
        const double across = 6.5 * std::sqrt(1 - z * z);
        out << across * std::cos(turn) << ',' << across * std::sin(turn) << ',' << 6.5 * z
            << ",1.4,1.4,1,0,0\n";
    }
    out.close();
    VoidsJob recipe;
    recipe.domain = fromOuter(hollowBall(folder));
    recipe.request.method = "list:" + list;
    recipe.request.shell = 1;
    recipe.request.voxelSize = 0.2;
    const VoidReport outer = *runVoids(recipe).report.voids;
    CHECK(outer.solidAttached.value() < 0.95);
    recipe.domain.shellFrom = ShellFrom::walls;
    CHECK(runVoids(recipe).report.voids->solidAttached.value() == Approx(1).margin(0.005));
}

TEST_CASE("measures by region take the shell from the outer surface") {
    const TemporaryFolder folder;
    const std::string bone = hollowBall(folder);
    PackJob recipe = recipeFor(bone, "uniform:0.3,0.6", folder.file("pack.csv"));
    runPack(recipe);
    auto measure = onPack<MeasureRecipe>(recipe.outputs.front().text);
    measure.domain = fromOuter(bone);
    measure.shell = kShell;
    const auto structure = runMeasure(measure).structure;
    REQUIRE(structure.regions.size() == 2);
    CHECK(structure.regions[1].volume ==
          Approx(ball(kOuter - kShell) - ball(kInner)).epsilon(0.015));
    // Spheres lie as densely on either side of the shell's inner face.
    CHECK(structure.regions[1].solidFraction > 0.45);
    CHECK(structure.regions[1].solidFraction < 0.66);
}

TEST_CASE("a shell from the outer surface is warned of where it means nothing") {
    const TemporaryFolder folder;

    PackJob plain = recipeFor("box:10,10,10", "uniform:0.5,1");
    plain.domain.shellFrom = ShellFrom::outer;
    plain.request.shell = 1;
    const auto warnings = runPack(plain).report.warnings;
    REQUIRE_FALSE(warnings.empty());
    CHECK(warnings.front().find("`shellFrom`") != std::string::npos);
}
