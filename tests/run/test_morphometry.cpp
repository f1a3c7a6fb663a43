// `measure` as a user calls it: the morphometry of solids and of spheres in a domain.
#include "support/generators.h"
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/test.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/report/image_result.h"

#include <nlohmann/json.hpp>

namespace {

Callbacks hearing(std::string& warned) {
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warned += text + "\n"; };
    return callbacks;
}

/// The solid that a Boolean model of voids leaves of a domain, in a file.
void writeSolid(const std::string& domain, const std::string& file) {
    auto recipe = voidsIn(domain, file);
    setVoids(recipe.request, "boolean", "uniform:1.2,1.6", 0.3);
    recipe.request.voxelSize = 0.5;
    recipe.threads = 2;
    runVoids(recipe);
}

Morphometry measured(const std::string& file, const std::string& domain, double shell,
                     std::string& warned) {
    auto recipe = onPack<MeasureRecipe>(file, domain);
    recipe.domain.gridName = "solid";
    recipe.shell = shell;
    recipe.threads = 2;
    return runMeasure(recipe, hearing(warned)).morphometry.value();
}

}  // namespace

TEST_CASE("with the bone as domain, the air around it is no pore") {
    const TemporaryFolder folder;
    writeObj(ballMesh(14, 5), folder.file("bone.obj"));
    writeSolid(folder.file("bone.obj"), folder.file("s.vdb"));
    std::string warned;
    const auto m = measured(folder.file("s.vdb"), folder.file("bone.obj"), 3, warned);
    CHECK(m.walled);
    CHECK(m.totalVolume == Approx(Measure<3>::ball(14)).epsilon(0.02));
    CHECK(m.solidFraction == Approx(0.3).epsilon(0.05));
    // Voids are 2.4 to 3.2 wide and twice as long, and overlap.
    CHECK(m.separation.value().max < 6.4);
    CHECK(m.border.continued < 0.1);
    CHECK(m.border.poresNearWall.value() > 0.05);
    REQUIRE(m.regions.size() == 2);
    for (const auto& region : m.regions) {
        CHECK(region.separation.value().max < 6.4);
        CHECK(region.anisotropy);
        CHECK(region.number);
    }
    CHECK(m.regions[1].totalVolume == Approx(Measure<3>::ball(11)).epsilon(0.02));
    CHECK(m.regions[0].deltaEuler + m.regions[1].deltaEuler == Approx(m.deltaEuler).margin(1e-6));
    CHECK(warned.empty());
}

TEST_CASE("parts of a sample have its connectivity density whatever their shape") {
    const TemporaryFolder folder;
    writeSolid("box:24,24,24", folder.file("s.vdb"));
    std::string warned;
    const auto whole = measured(folder.file("s.vdb"), "box:24,24,24", 0, warned);
    const auto box = measured(folder.file("s.vdb"), "box:20,20,20", 0, warned);
    const auto ball = measured(folder.file("s.vdb"), "ball:11.5", 0, warned);
    CHECK(warned.empty());
    CHECK(box.connectivityDensity == Approx(whole.connectivityDensity).epsilon(0.2));
    CHECK(ball.connectivityDensity == Approx(whole.connectivityDensity).epsilon(0.2));
    CHECK_FALSE(ball.walled);
    CHECK(ball.border.continued > 0.5);
    CHECK(ball.separation.value().mean == Approx(box.separation.value().mean).epsilon(0.05));

    // Without a domain it is a body that ends at its bounding box, and that is said.
    const auto alone = measured(folder.file("s.vdb"), "", 0, warned);
    CHECK(alone.connectivityDensity < 0.95 * whole.connectivityDensity);
    CHECK(alone.deltaEuler == alone.eulerNumber);
    CHECK_THAT(warned, Contains("s.vdb") && Contains("`domain`") && Contains("box:"));
    // It has no spheres to join.
    auto solid = onPack<MeasureRecipe>(folder.file("s.vdb"));
    solid.domain.gridName = "solid";
    solid.sphereMorphometry = true;
    CHECK_THROWS_WITH(runMeasure(solid), Contains("s.vdb") && Contains("`sphereMorphometry`"));
    // A domain that the solid does not fill is said, too.
    warned.clear();
    measured(folder.file("s.vdb"), "ball:30", 0, warned);
    CHECK_THAT(warned, Contains("s.vdb") && Contains("`domain`"));
}

TEST_CASE("the spheres of a pack are measured as one solid") {
    const TemporaryFolder folder;
    // A simple cubic lattice of touching balls.
    Pack<3> pack;
    for (int i = 0; i < 216; ++i)
        pack.spheres.push_back(
            {{{2.0 * (i % 6) - 5, 2.0 * (i / 6 % 6) - 5, 2.0 * (i / 36) - 5}}, 1});
    writePack(pack, folder.file("p.csv"));
    auto recipe = onPack<MeasureRecipe>(folder.file("p.csv"), "box:12,12,12");
    recipe.domain.voxelSize = 0.125;
    recipe.sphereMorphometry = true;
    recipe.reportFile = folder.file("r.html");
    const auto result = runMeasure(recipe);
    REQUIRE(result.spheres);
    CHECK_THAT(contentOf(folder.file("r.html")), Contains("Morphometry") && Contains("Tb.Sp"));
    recipe.reportFile.clear();
    CHECK(result.spheres->dilation == Approx(0.05));
    CHECK(result.spheres->dilationOfMeanRadius == Approx(0.05));
    const Morphometry& m = result.spheres->morphometry;
    // Balls of 1.05 less the caps of height 0.05 that neighbors or the wall cut off.
    const double cap = kPi * 0.05 * 0.05 * (3 * 1.05 - 0.05) / 3;
    CHECK(m.solidFraction == Approx((Measure<3>::ball(1.05) - 6 * cap) / 8).epsilon(0.015));
    // Six neighbors a ball: 216 nodes, 540 necks.
    CHECK(m.eulerNumber == 216 - 540);
    CHECK(m.connectivity == 1 - (216 - 540));
    CHECK(m.thickness.value().mean == Approx(2.1).epsilon(0.03));
    // Between eight balls there is room for one of radius sqrt(3) - 1.05.
    CHECK(m.separation.value().max == Approx(2 * (std::sqrt(3.0) - 1.05)).epsilon(0.05));
    CHECK(m.walled);
    const auto json = toJson(result);
    CHECK(json["morphometry"]["of"] == "spheres");
    CHECK(json["morphometry"]["dilation"].get<double>() == Approx(0.05));
    CHECK(json["morphometry"]["BV/TV"].get<double>() == Approx(m.solidFraction));
    // The figures of the pack stay beside them.
    CHECK(json["contacts"]["components"] == 1);
    CHECK_THAT(summary(result), Contains("0.05 mm") && Contains("Tb.Sp"));

    // Half of the lattice: the necks across its faces are cut, half of each counts.
    recipe.domain.source = "box:8,8,8";
    const auto part = runMeasure(recipe).spheres->morphometry;
    CHECK_FALSE(part.walled);
    CHECK(part.deltaEuler == Approx(64 - 3 * 64).epsilon(0.02));

    recipe.dilation = 0;
    recipe.domain.source = "box:12,12,12";
    CHECK(runMeasure(recipe).spheres->morphometry.solidFraction == Approx(kPi / 6).epsilon(0.015));
    recipe.sphereMorphometry = false;
    CHECK_THROWS_WITH(runMeasure(recipe), Contains("`dilation`"));
}

TEST_CASE("dilation makes necks of the contacts of a pack") {
    const TemporaryFolder folder;
    runPack(recipeFor("ball:9", "uniform:1,1.5", folder.file("p.csv")));
    auto recipe = onPack<MeasureRecipe>(folder.file("p.csv"), "ball:9");
    recipe.sphereMorphometry = true;
    recipe.shell = 3;
    const auto dilated = runMeasure(recipe);
    const Morphometry& m = dilated.spheres->morphometry;
    CHECK(m.totalVolume == Approx(Measure<3>::ball(9)).epsilon(0.02));
    CHECK(m.solidFraction > *dilated.run.report.solidFractionTotal);
    CHECK(m.separation.value().max < 3);
    REQUIRE(m.regions.size() == 2);
    CHECK(m.regions[1].thickness.value().mean > 2);
    // One body with about as many loops as contacts more than spheres.
    const double spheres = static_cast<double>(dilated.run.report.count);
    const double contacts = static_cast<double>(dilated.run.report.contacts->pairs);
    CHECK(m.connectivity > 0.8 * (contacts - spheres));
    recipe.dilation = 0;
    CHECK(runMeasure(recipe).spheres->morphometry.solidFraction ==
          Approx(*dilated.run.report.solidFractionTotal).epsilon(0.02));
}

TEST_CASE("a mesh has its own volume, wherever its faces lie between voxels") {
    const TemporaryFolder folder;
    const Vec<3> size = GENERATE(Vec<3>{{40, 40, 1}}, Vec<3>{{100, 50, 3}}, Vec<3>{{40, 1, 1}});
    const std::string domain = GENERATE("", "box:-0.3,-0.3,-0.3,101,51,4");
    writeObj(boxMesh({}, size), folder.file("plate.obj"));
    std::string warned;
    const auto m = measured(folder.file("plate.obj"), domain, 0, warned);
    const double volume = size[0] * size[1] * size[2];
    CHECK(m.solidVolume == Approx(volume));
    CHECK(m.totalVolume == Approx(domain.empty() ? volume : 101.3 * 51.3 * 4.3));
    CHECK(m.solidFraction == Approx(m.solidVolume / m.totalVolume));
}

namespace {

ImageGrid smallGrid(const std::array<std::size_t, 3>& size, const Vec<3>& spacing) {
    ImageGrid grid;
    grid.size = size;
    for (std::size_t d = 0; d < 3; ++d) grid.step[d] = grid.step[d] * spacing.c[d];
    return grid;
}

}  // namespace

TEST_CASE("the border of an image is no surface") {
    const TemporaryFolder folder;
    const std::size_t n = GENERATE(30, 60);
    const auto slab =
        Voxels<std::uint8_t>::of(smallGrid({n, n, 40}, {{0.1, 0.1, 0.1}}),
                                 [](const Vec<3>& p) { return p[2] > 1.55 && p[2] < 2.35; });
    writeNrrd(folder.file("slab.nrrd"), slab, "uint8");
    std::string warned;
    const auto m = measured(folder.file("slab.nrrd"), "", 0, warned);
    const double side = 0.1 * static_cast<double>(n);
    CHECK(m.structureModelIndex.value() == Approx(0).margin(0.01));
    CHECK(m.solidSurface == Approx(2 * side * side).epsilon(0.001));
    CHECK(m.solidVolume == Approx(0.8 * side * side));
    CHECK(m.thickness.value().mean == Approx(0.8).epsilon(0.01));
}

TEST_CASE("an image is measured in its own voxels") {
    const TemporaryFolder folder;
    // A ball and four struts one voxel thick.
    auto image =
        Voxels<std::uint8_t>::of(smallGrid({40, 40, 40}, {{1, 1, 1}}), [](const Vec<3>& p) {
            const Vec<3> strut{{std::fmod(p[0] - 22, 4), p[1] - 4, 0}};
            return length(p - Vec<3>{{10, 20, 20}}) <= 8 ||
                   (p[0] > 21 && p[0] < 35 && length(strut) == 0 && p[2] > 2 && p[2] < 37);
        });
    const auto solid =
        static_cast<double>(std::count(image.values.begin(), image.values.end(), std::uint8_t{1}));
    writeNrrd(folder.file("struts.nrrd"), image, "uint8");
    std::string warned;
    const auto m = measured(folder.file("struts.nrrd"), "", 0, warned);
    CHECK(m.ofVoxels);
    CHECK(m.solidVolume == solid);
    CHECK(m.totalVolume == 64000);
    CHECK(m.eulerNumber == 5);
    CHECK(m.largestComponent.value() == Approx((solid - 4 * 34) / solid));

    // Voxels that are no cubes are counted as well; the rest is of the surface.
    image.grid = smallGrid({40, 40, 40}, {{1, 0.7, 0.9}});
    writeNrrd(folder.file("flat.nrrd"), image, "uint8");
    const auto flat = measured(folder.file("flat.nrrd"), "", 0, warned);
    CHECK_FALSE(flat.ofVoxels);
    CHECK(flat.solidVolume == Approx(0.63 * solid));
    CHECK(flat.totalVolume == Approx(0.63 * 64000));
    CHECK_THAT(summary(flat), Contains("of the surface"));
}

TEST_CASE("walls thinner than the voxels of an image are measured in these") {
    const TemporaryFolder folder;
    // Above the threshold a layer of two voxels, and one whose surface encloses next to nothing.
    const auto image =
        Voxels<std::int16_t>::of(smallGrid({30, 30, 40}, {{1, 1, 1}}), [](const Vec<3>& p) {
            return p[2] == 10 ? 105 : p[2] == 25 || p[2] == 26 ? 500 : -1000;
        });
    writeNrrd(folder.file("walls.nrrd"), image, "int16");
    auto recipe = onPack<MeasureRecipe>(folder.file("walls.nrrd"));
    recipe.domain.threshold = 100;
    const auto m = runMeasure(recipe).morphometry.value();
    CHECK(m.ofVoxels);
    CHECK(m.solidVolume == 3 * 30 * 30);
    CHECK(m.eulerNumber == 2);
    // As a surface, in voxels that are given, the thin one would be lost.
    for (const double voxel : {1.0, 2.0}) {
        recipe.domain.voxelSize = voxel;
        CHECK_THROWS_WITH(runMeasure(recipe), Contains("too coarse"));
    }
}

TEST_CASE("distances of voxels that change nothing are named by every command") {
    const TemporaryFolder folder;
    const std::string file = folder.file("i.nrrd"), mesh = folder.file("m.obj");
    const auto image = Voxels<std::uint8_t>::of(smallGrid({20, 20, 20}, {{1, 1, 1}}),
                                                [](const Vec<3>& p) { return p[2] > 9; });
    writeNrrd(file, image, "uint8");
    writeObj(ballMesh(5, 3), mesh);
    Pack<3> one;
    one.spheres.push_back({{}, 1});
    writePack(one, folder.file("p.csv"));
    const Vec<3> spacing{{2, 2, 2}};
    for (const auto& [pack, domain, why] :
         {std::array<std::string, 3>{file, "", "states the distances"},
          {mesh, "", "is no image"},
          {mesh, file, "states the distances"},
          {folder.file("p.csv"), mesh, "is no image"}}) {
        CAPTURE(pack, domain);
        auto recipe = onPack<MeasureRecipe>(pack, domain);
        recipe.domain.voxelSpacing = spacing;
        recipe.domain.voxelSize = 0.5;
        std::string warned;
        runMeasure(recipe, hearing(warned));
        CHECK_THAT(warned, Contains("`voxelSpacing` 2") && Contains(why));
    }
    ImageRecipe seen;
    seen.domain.source = file;
    seen.domain.voxelSpacing = spacing;
    CHECK(mentions(runImage(seen).warnings, "`voxelSpacing` 2"));
    auto verified = onPack<VerifyRecipe>(folder.file("p.csv"), mesh);
    verified.domain.voxelSpacing = spacing;
    CHECK(mentions(runVerify(verified).report.warnings, "`voxelSpacing` 2"));
}
