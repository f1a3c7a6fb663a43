// Foams that have the numbers that were asked for.
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/run/structure_sample.h"
#include "vdbpack/voids/trabecular_presets.h"

namespace {

Morphometry measured(const std::string& file, const std::string& domain) {
    auto recipe = onPack<MeasureRecipe>(file, domain);
    recipe.domain.gridName = "solid";
    return *runMeasure(recipe).morphometry;
}

}  // namespace

TEST_CASE("a foam has the spacing asked for, and the report says how it was found", "[long]") {
    const TemporaryFolder folder;
    auto recipe = voidsIn("box:3.6,3.6,3.6", folder.file("v.vdb"));
    recipe.request.targetBvtv = 0.25;
    recipe.request.targetTbsp = 0.7;
    recipe.request.radius = "uniform:1,1.5";  // the spread; lengths are found
    recipe.request.jitter = 0.3;
    recipe.request.blend = 0.03;
    recipe.request.strutShare = 0.5;
    recipe.request.voxelSize = 0.06;
    const auto report = runVoids(recipe).report.voids;
    REQUIRE(report->targets.size() == 1);
    CHECK(report->targets[0].name == "targetTbsp");
    CHECK(report->targets[0].reached == Approx(0.7).epsilon(0.03));
    CHECK(report->targets[0].scatter.value_or(0) > 0);
    const Morphometry m = measured(folder.file("v.vdb"), "box:3.6,3.6,3.6");
    CHECK(m.separation->mean == Approx(report->targets[0].reached).epsilon(0.005));
    CHECK(m.solidFraction == Approx(0.25).epsilon(0.01));
    CHECK(report->parameters.find("`voids.jitter` 0.3") != std::string::npos);
}

TEST_CASE("a foam has all the numbers that are asked for at once", "[.slow]") {
    struct Asked {
        double bvtv, tbth, tbsp, da;
        std::optional<double> connd;
    };
    const auto asked = GENERATE(Asked{0.193, 0.238, 0.831, 0.494, 3.57},
                                Asked{0.22, 0.24, 0.74, 0.4, std::nullopt});
    CAPTURE(asked.bvtv);
    const TemporaryFolder folder;
    const std::string file = folder.file("v.vdb");
    const std::string box = asked.connd ? "box:4.2,4.2,4.2" : "box:3.8,3.8,3.8";
    auto recipe = voidsIn(box, file);
    if (asked.connd) recipe.seed = 2;
    recipe.request.targetBvtv = asked.bvtv;
    recipe.request.targetTbth = asked.tbth;
    recipe.request.targetTbsp = asked.tbsp;
    recipe.request.targetDa = asked.da;
    recipe.request.targetConnd = asked.connd;
    const auto report = runVoids(recipe).report.voids;
    CHECK(report->method == "foam");
    const Morphometry m = measured(file, box);
    CHECK(m.solidFraction == Approx(asked.bvtv).epsilon(0.01));
    CHECK(m.thickness->mean == Approx(asked.tbth).epsilon(0.03));
    CHECK(m.separation->mean == Approx(asked.tbsp).epsilon(0.03));
    CHECK(m.anisotropy->degree == Approx(asked.da).epsilon(0.03));
    if (asked.connd)
        CHECK(m.connectivityDensity == Approx(*asked.connd).epsilon(0.1));  // 260 loops
    CHECK(m.largestComponent.value_or(0) > 0.99);
    CHECK(*report->solidAttached > (asked.connd ? 0.98 : 0.99));
    // The trabeculae are along z by default.
    CHECK(std::fabs(m.anisotropy->axes[0][2]) > 0.95);
    // What the report says is what a measurement says.
    REQUIRE(report->targets.size() == (asked.connd ? 4 : 3));
    CHECK(report->targets[0].reached == Approx(m.thickness->mean).epsilon(0.005));
    CHECK(report->targets[1].reached == Approx(m.separation->mean).epsilon(0.005));
    CHECK(report->targets[2].reached == Approx(m.anisotropy->degree).epsilon(0.02));
    for (const auto& t : report->targets) CHECK(t.scatter.value_or(0) > 0);
}

TEST_CASE("a foam is like a sample that was made by other means", "[.slow]") {
    const TemporaryFolder folder;
    const std::string sample = folder.file("sample.vdb"), file = folder.file("v.vdb");
    const std::string box = "box:5,5,5";
    auto made = voidsIn(box, sample);
    made.request.method = GENERATE("boolean", "foam", "overlay");
    CAPTURE(made.request.method);
    const bool foam = made.request.method == "foam", overlay = made.request.method == "overlay";
    made.request.radius = foam ? "uniform:0.25,0.5" : "uniform:0.22,0.35";
    made.request.aspect = "constant:1.5";
    made.request.orientation.axis = VoidAxis::parse("1,0,0");
    if (!overlay) made.request.targetBvtv = foam ? 0.16 : 0.3;
    made.request.voxelSize = 0.05;
    made.seed = 7;
    runVoids(made);
    const Morphometry asked = measured(sample, box);
    auto recipe = voidsIn(box, file);
    recipe.request.like = sample;
    recipe.request.likeDomain = box;
    recipe.request.voxelSize = 0.05;
    const auto report = runVoids(recipe).report;
    const Morphometry m = measured(file, box);
    // A number that is missed is named.
    std::string warnings;
    for (const auto& w : report.warnings) warnings += w;
    const auto near = [&](const char* name, double value, double target) {
        CAPTURE(name, value, target, warnings);
        CHECK((std::fabs(value / target - 1) < 0.06 || warnings.find(name) != std::string::npos));
    };
    near("targetBvtv", m.solidFraction, asked.solidFraction);
    near("targetTbth", m.thickness->mean, asked.thickness->mean);
    near("targetTbsp", m.separation->mean, asked.separation->mean);
    near("targetDa", m.anisotropy->degree, asked.anisotropy->degree);
    if (overlay)
        CHECK(warnings.find("Conn.D") != std::string::npos);  // closed voids have none
    else
        near("targetConnd", m.connectivityDensity, asked.connectivityDensity);
    CHECK(std::fabs(m.anisotropy->axes[0][0]) > 0.95);
    // The distances of the report are those of a measurement.
    const double thickness = ksDistance(*m.thickness, *asked.thickness),
                 separation = ksDistance(*m.separation, *asked.separation);
    CHECK(*report.voids->thicknessDistance == Approx(thickness).margin(0.01));
    CHECK(*report.voids->separationDistance == Approx(separation).margin(0.01));
    if (foam) {
        CHECK(thickness < 0.12);
        CHECK(separation < 0.12);
    }
}

TEST_CASE("a foam is like a lattice of struts in an image", "[.slow]") {
    const TemporaryFolder folder;
    const std::string sample = folder.file("lattice.nrrd"), file = folder.file("v.vdb");
    ImageGrid grid = gridAround(2.4, {{0.03, 0.03, 0.03}});
    grid.size = {160, 160, 160};
    grid.origin = {{0.015, 0.015, 0.015}};
    const auto inSolid = [](const Vec<3>& at) {
        const double x = std::remainder(at[0], 0.8), y = std::remainder(at[1], 0.8),
                     z = std::remainder(at[2], 1);
        return std::hypot(x, y) < 0.1265 || std::hypot(x, z) < 0.11 || std::hypot(y, z) < 0.11;
    };
    writeNrrd(sample, Voxels<std::uint8_t>::of(grid, inSolid), "uint8");
    auto measure = onPack<MeasureRecipe>(sample);
    const Morphometry asked = *runMeasure(measure).morphometry;
    const std::string box = "box:4.8,4.8,4.8";
    auto recipe = voidsIn(box, file);
    recipe.request.like = sample;
    runVoids(recipe);
    const Morphometry m = measured(file, box);
    CHECK(m.solidFraction == Approx(asked.solidFraction).epsilon(0.02));
    CHECK(m.thickness->mean == Approx(asked.thickness->mean).epsilon(0.06));
    CHECK(m.separation->mean == Approx(asked.separation->mean).epsilon(0.06));
    CHECK(m.anisotropy->degree == Approx(asked.anisotropy->degree).epsilon(0.06));
    CHECK(m.connectivityDensity == Approx(asked.connectivityDensity).epsilon(0.06));
}

TEST_CASE("a sample that states no distances of its voxels has those that are set") {
    const TemporaryFolder folder;
    const ImageGrid grid = gridAround(1, {{0.05, 0.05, 0.05}});
    const auto v = Voxels<std::uint8_t>::of(grid, [](const Vec<3>& at) {
        return std::hypot(std::remainder(at[0], 0.5), std::remainder(at[1], 0.5)) < 0.12 ||
               std::hypot(std::remainder(at[0], 0.5), std::remainder(at[2], 0.5)) < 0.12;
    });
    writeNrrd(folder.file("stated.nrrd"), v, "uint8");
    const std::string n = std::to_string(grid.size[0]);
    writeBytes(folder.file("open.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: " + n + ' ' +
                                             n + ' ' + n + "\nencoding: raw\n\n" +
                                             bytesOfValues(v.values));
    auto recipe = voidsIn("box:4,4,4");
    recipe.request.like = folder.file("stated.nrrd");
    const FoamTargets stated =
        withSample(settled(recipe).voids, recipe.domain, {}).as<FoamVoids>()->targets;
    recipe.request.like = folder.file("open.nrrd");
    CHECK_THROWS_AS(runVoids(recipe), InputError);
    recipe.domain.voxelSpacing = Vec<3>{{0.05, 0.05, 0.05}};
    const FoamTargets open =
        withSample(settled(recipe).voids, recipe.domain, {}).as<FoamVoids>()->targets;
    CHECK(open.tbth.value() == Approx(stated.tbth.value()));
    CHECK(open.tbsp.value() == Approx(stated.tbsp.value()));
    // No warning that they have no effect, also where another image than the sample has them.
    auto graded = voidsIn("box:2,2,2");
    setVoids(graded.request, "boolean", "constant:0.3");
    graded.request.bvtvField = folder.file("open.nrrd");
    graded.request.bvtvRange = "0,1";
    graded.domain.voxelSpacing = recipe.domain.voxelSpacing;
    CHECK_FALSE(mentions(runVoids(graded).report.warnings, "voxelSpacing"));
}

TEST_CASE("foams in the plane have the area fraction and thickness asked for") {
    const TemporaryFolder folder;
    auto recipe = voidsIn("rect:20,20", folder.file("v.svg"));
    recipe.outputs = {"list:" + folder.file("l.csv")};
    setVoids(recipe.request, "foam", "", GENERATE(0.15, 0.35));
    recipe.request.targetTbth = 0.25;
    const auto report = runVoids(recipe).report.voids;
    CHECK(*report->bvtv == Approx(*recipe.request.targetBvtv).epsilon(0.03));
    CHECK(*report->thickness == Approx(0.25).epsilon(0.03));
}

TEST_CASE("samples that are no structure are refused") {
    const TemporaryFolder folder;
    auto recipe = voidsIn("box:4,4,4", folder.file("v.vdb"));
    auto solid = voidsIn("box:2,2,2", folder.file("full.vdb"));
    setVoids(solid.request, "boolean", "constant:0.01");
    solid.request.count = 1;
    solid.request.voxelSize = 0.1;
    runVoids(solid);
    recipe.request.like = folder.file("full.vdb");
    CHECK_THAT(messageOf<InputError>([&] { runVoids(recipe); }), Contains("full.vdb"));
}

TEST_CASE("presets have numbers that go together, and a source") {
    for (const TrabecularPreset& p : trabecularPresets()) {
        CAPTURE(p.name);
        CHECK(std::string(p.source).size() > 8);
        CHECK((p.bvtv || p.tbth || p.tbsp));
        VoidRequest request;
        request.trabecular = p.name;
        request.targetTbsp = 0.9;
        const VoidRecipe made = voidsOf(request);
        REQUIRE(made.as<FoamVoids>());
        CHECK(targetBvtvOf(made) == p.bvtv);
        CHECK(made.as<FoamVoids>()->targets.tbsp == 0.9);  // what is given stays
        request.targetTbsp.reset();
        CHECK_NOTHROW(checkVoids(voidsOf(request), false, false));
        CHECK_THAT(presetTable(), Contains(p.name) && Contains(p.source));
    }
}
