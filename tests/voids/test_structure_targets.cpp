// Foams that have the numbers that were asked for.
#include "cli/recipes.h"
#include "support/image_file.h"
#include "support/message_of.h"
#include "support/temporary_folder.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

VoidsJob structure(const std::string& source, const std::string& output) {
    VoidsJob recipe;
    recipe.domain.source = source;
    recipe.outputs = {output};
    return recipe;
}

Morphometry measured(const std::string& file, const std::string& domain) {
    MeasureRecipe recipe;
    recipe.pack = file;
    recipe.domain.source = domain;
    recipe.domain.gridName = "solid";
    return *runMeasure(recipe).morphometry;
}

}  // namespace

TEST_CASE("a foam has the thickness, spacing and anisotropy asked for", "[run][voids][.slow]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("v.vdb"), box = "box:3.8,3.8,3.8";
    auto recipe = structure(box, file);
    recipe.request.targetBvtv = 0.22;
    recipe.request.targetTbth = 0.24;
    recipe.request.targetTbsp = 0.74;
    recipe.request.targetDa = 0.4;
    const auto report = runVoids(recipe).report.voids;
    CHECK(report->method == "foam");
    const Morphometry m = measured(file, box);
    CHECK(m.solidFraction == Approx(0.22).epsilon(0.01));
    CHECK(m.thickness->mean == Approx(0.24).epsilon(0.03));
    CHECK(m.separation->mean == Approx(0.74).epsilon(0.03));
    CHECK(m.anisotropy->degree == Approx(0.4).epsilon(0.03));
    // The trabeculae are along z by default.
    CHECK(std::fabs(m.anisotropy->axes[0][2]) > 0.95);
    CHECK(*report->solidAttached > 0.99);
    // What the report says is what a measurement says.
    REQUIRE(report->targets.size() == 3);
    CHECK(report->targets[0].reached == Approx(m.thickness->mean).epsilon(0.005));
    CHECK(report->targets[1].reached == Approx(m.separation->mean).epsilon(0.005));
    CHECK(report->targets[2].reached == Approx(m.anisotropy->degree).epsilon(0.02));
    for (const auto& t : report->targets) CHECK(t.scatter.value_or(0) > 0);
}

TEST_CASE("a foam has the spacing asked for, and the report says how it was found",
          "[run][voids][long]") {
    const TemporaryFolder folder;
    auto recipe = structure("box:3.6,3.6,3.6", folder.file("v.vdb"));
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
    CHECK(report->parameters.find("--void-jitter 0.3") != std::string::npos);
}

TEST_CASE("a foam has five numbers at once, whatever the seed", "[run][voids][.slow]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("v.vdb"), box = "box:4.2,4.2,4.2";
    double lastX = 0;
    for (const std::uint64_t seed : {1, 2}) {
        auto recipe = structure(box, file);
        recipe.seed = seed;
        recipe.request.targetBvtv = 0.193;
        recipe.request.targetTbth = 0.238;
        recipe.request.targetTbsp = 0.831;
        recipe.request.targetDa = 0.494;
        recipe.request.targetConnd = 3.57;
        const auto result = runVoids(recipe);
        const Morphometry m = measured(file, box);
        CHECK(m.solidFraction == Approx(0.193).epsilon(0.01));
        CHECK(m.thickness->mean == Approx(0.238).epsilon(0.03));
        CHECK(m.separation->mean == Approx(0.831).epsilon(0.03));
        CHECK(m.anisotropy->degree == Approx(0.494).epsilon(0.03));
        CHECK(m.connectivityDensity == Approx(3.57).epsilon(0.1));  // some 260 loops
        CHECK(m.largestComponent.value_or(0) > 0.99);
        // Another specimen, not the same again.
        const double x = std::get<std::vector<Ellipsoid<3>>>(result.voids).front().center[0];
        CHECK(x != lastX);
        lastX = x;
    }
}

TEST_CASE("a foam is like a sample that was made by other means", "[run][voids][.slow]") {
    const TemporaryFolder folder;
    const std::string sample = folder.file("sample.vdb"), file = folder.file("v.vdb");
    const std::string box = "box:5,5,5";
    auto made = structure(box, sample);
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
    auto recipe = structure(box, file);
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

TEST_CASE("a foam is like a lattice of struts in an image", "[run][voids][.slow]") {
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
    MeasureRecipe measure;
    measure.pack = sample;
    const Morphometry asked = *runMeasure(measure).morphometry;
    const std::string box = "box:4.8,4.8,4.8";
    auto recipe = structure(box, file);
    recipe.request.like = sample;
    runVoids(recipe);
    const Morphometry m = measured(file, box);
    CHECK(m.solidFraction == Approx(asked.solidFraction).epsilon(0.02));
    CHECK(m.thickness->mean == Approx(asked.thickness->mean).epsilon(0.06));
    CHECK(m.separation->mean == Approx(asked.separation->mean).epsilon(0.06));
    CHECK(m.anisotropy->degree == Approx(asked.anisotropy->degree).epsilon(0.06));
    CHECK(m.connectivityDensity == Approx(asked.connectivityDensity).epsilon(0.06));
}

TEST_CASE("foams in the plane have the area fraction and thickness asked for", "[run][voids]") {
    const TemporaryFolder folder;
    auto recipe = structure("rect:20,20", folder.file("v.svg"));
    recipe.outputs = {"list:" + folder.file("l.csv")};
    recipe.request.method = "foam";
    recipe.request.targetBvtv = GENERATE(0.15, 0.35);
    recipe.request.targetTbth = 0.25;
    const auto report = runVoids(recipe).report.voids;
    CHECK(*report->bvtv == Approx(*recipe.request.targetBvtv).epsilon(0.03));
    CHECK(*report->thickness == Approx(0.25).epsilon(0.03));
    recipe.request.targetDa = 0.5;
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(recipe); }), Contains("targetDa"));
}

TEST_CASE("targets that contradict one another are refused with what is possible", "[run][voids]") {
    const TemporaryFolder folder;
    auto recipe = structure("box:4,4,4", folder.file("v.vdb"));
    recipe.request.targetBvtv = 0.3;
    recipe.request.targetTbth = 0.1;
    recipe.request.targetTbsp = 2;
    const auto message = messageOf<ParameterError>([&] { runVoids(recipe); });
    for (const char* part : {"targetBvtv", "0.3", "targetTbth", "0.1", "targetTbsp", "0.076"})
        CHECK_THAT(message, Contains(part));
    recipe.request = {};
    recipe.request.targetDa = 1.48;  // a ratio
    recipe.request.targetTbsp = 1;
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(recipe); }), Contains("1 - 1 / R²"));
    recipe.request.targetDa = 0.5;
    recipe.request.method = "boolean";
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(recipe); }), Contains("foam"));
}

TEST_CASE("samples that are no structure are refused", "[run][voids]") {
    const TemporaryFolder folder;
    auto recipe = structure("box:4,4,4", folder.file("v.vdb"));
    recipe.request.like = folder.file("none.vdb");
    CHECK_THROWS_AS(runVoids(recipe), IoError);
    auto solid = structure("box:2,2,2", folder.file("full.vdb"));
    solid.request.method = "boolean";
    solid.request.radius = "constant:0.01";
    solid.request.count = 1;
    solid.request.voxelSize = 0.1;
    runVoids(solid);
    recipe.request.like = folder.file("full.vdb");
    CHECK_THAT(messageOf<InputError>([&] { runVoids(recipe); }), Contains("full.vdb"));
    recipe.request.like.clear();
    recipe.request.likeThreshold = 3;
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(recipe); }), Contains("`like`"));
}

TEST_CASE("presets have numbers that go together, and a source", "[voids]") {
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
    VoidRequest unknown;
    unknown.trabecular = "tooth";
    CHECK_THAT(messageOf<ParameterError>([&] { voidsOf(unknown); }),
               Contains("tooth") && Contains("vertebra"));
}
