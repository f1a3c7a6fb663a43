// From one format to another, and what is made of level sets on the way.
#include "formats/lattice_pack.h"
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/run/run.h"
#include "vdbpack/verify/verify.h"

#include <nlohmann/json.hpp>

namespace {

ConvertRecipe recipeOf(const std::string& from, const std::vector<std::string>& to) {
    auto recipe = onPack<ConvertRecipe>(from);
    recipe.outputs = {to.begin(), to.end()};
    return recipe;
}

}  // namespace

TEST_CASE("a pack through every format and back is the same doubles") {
    const TemporaryFolder scratch;
    auto pack = latticePack<3>(300, {{0, 10, 40}}, 30, 2);
    writePack(pack, scratch.file("first.csv"), {});
    std::string from = scratch.file("first.csv");
    for (const std::string to :
         {"a.npz", "b.xyz", "c.vtp", "d.vtkhdf", "d.vdb", "e.csv", "f.data"}) {
        CAPTURE(from, to);
        const auto result = runConvert(recipeOf(from, {scratch.file(to)}));
        REQUIRE(result.kind == "spheres");
        REQUIRE(result.count == 300);
        REQUIRE(result.hash == packHash(pack));
        REQUIRE(result.files == std::vector<std::string>{scratch.file(to)});
        from = scratch.file(to);
        const auto read = readPack(from);
        REQUIRE(read.spheres == pack.spheres);
        REQUIRE(read.id == pack.id);
        REQUIRE(read.region == pack.region);
        if (to == "f.data") continue;
        REQUIRE(read.order == pack.order);
        REQUIRE(read.depth == pack.depth);
        REQUIRE(read.contacts == pack.contacts);
    }
    runConvert(
        recipeOf(from, {"yade:" + (scratch.file("g.txt")), "points:" + (scratch.file("h.vdb"))}));
    REQUIRE(readPack("yade:" + (scratch.file("g.txt"))).spheres == pack.spheres);
    REQUIRE(readPack(scratch.file("h.vdb")).spheres == pack.spheres);
}

TEST_CASE("a pack keeps the axes of its patient and its tolerances from file to file") {
    const TemporaryFolder scratch;
    PackWriteOptions options;
    options.generator = generatorWith("a program", {"RAS", 0.05, 0.4});
    std::string from = scratch.file("first.vtp");
    writePack(latticePack<3>(20, {{0, 10, 40}}, 30, 2), from, options);
    for (const std::string to : {"a.npz", "b.xyz", "c.pvtp", "d.vtkhdf", "e.vdb", "f.data"}) {
        CAPTURE(from, to);
        runConvert(recipeOf(from, {scratch.file(to)}));
        from = scratch.file(to);
        const PackOrigin kept = readPack(from).origin;
        CHECK(kept.axes == "RAS");
        CHECK(kept.contactTolerance == 0.05);
        CHECK(kept.interfaceTolerance == 0.4);
    }
    runConvert(recipeOf(from, {scratch.file("g.csv")}));
    CHECK(readPack(scratch.file("g.csv")).origin.axes.empty());
    options.generator = "another; axes up";
    writePack(latticePack<3>(20, {{0, 10, 40}}, 30, 2), from, options);
    CHECK(readPack(from).origin.axes.empty());
}

TEST_CASE("circles stay circles") {
    const TemporaryFolder scratch;
    auto pack = latticePack<2>(50, {{0, 10}}, 30, 2);
    pack.sliceHeight = 7;
    writePack(pack, scratch.file("p.csv"), {});
    const auto result =
        runConvert(recipeOf(scratch.file("p.csv"), {scratch.file("p.svg"), scratch.file("p.npz")}));
    REQUIRE(result.kind == "circles");
    REQUIRE(asCircles(readPack(scratch.file("p.npz"))).spheres == pack.spheres);
    REQUIRE_THROWS_WITH(runConvert(recipeOf(scratch.file("p.csv"), {scratch.file("p.stl")})),
                        Contains("p.stl"));
}

TEST_CASE("a domain gives a converted pack its surface and its bulk density") {
    const TemporaryFolder scratch;
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}};
    writePack(pack, scratch.file("p.csv"), {});
    auto recipe = recipeOf(scratch.file("p.csv"), {scratch.file("p.data"), scratch.file("p.stl"),
                                                   "fog:" + (scratch.file("fog.vdb")),
                                                   "levelsets:" + (scratch.file("l.vdb"))});
    recipe.density = "bulk:1000";
    REQUIRE_THROWS_WITH(runConvert(recipe), Contains("`domain`"));
    recipe.domain.source = "ball:2";
    recipe.outUnit = Unit::meter;
    runConvert(recipe);
    // A ball of half the radius takes an eighth.
    const auto read = readPack(scratch.file("p.data"));
    REQUIRE(read.columns.back().numbers[0] == Approx(8000).epsilon(1e-6));
    MeshReadOptions meters;
    meters.unit = Unit::meter;
    const auto mesh = readMesh(scratch.file("p.stl"), meters);
    const auto health = toJson(checkMesh(mesh));
    CAPTURE(health.dump(1));
    REQUIRE(mesh.bounds().size()[0] == Approx(4).epsilon(0.01));
    double volume = 0;
    for (const auto& t : mesh.triangles)
        volume += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]])) / 6;
    REQUIRE(volume == Approx(4 * kPi / 3 * 8).epsilon(0.01));  // positive: outward
    REQUIRE(holdsLevelSet(scratch.file("l.vdb")));
    REQUIRE_FALSE(holdsLevelSet(scratch.file("fog.vdb")));
    REQUIRE_THROWS_AS(readPack(scratch.file("l.vdb")), InputError);
}

TEST_CASE("solids are converted between level set and surface") {
    const TemporaryFolder scratch;
    auto recipe = recipeOf(scratch.file("p.csv"), {"levelsets:" + (scratch.file("l.vdb"))});
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}};
    writePack(pack, scratch.file("p.csv"), {});
    recipe.domain.source = "ball:5";
    runConvert(recipe);
    REQUIRE(runConvert(recipeOf(scratch.file("l.vdb"), {scratch.file("s.stl")})).kind ==
            "level set");
    const auto again =
        runConvert(recipeOf(scratch.file("s.stl"), {scratch.file("t.vdb"), scratch.file("t.stl")}));
    REQUIRE(again.kind == "mesh");
    REQUIRE(readMesh(scratch.file("t.stl")).vertices == readMesh(scratch.file("s.stl")).vertices);
    REQUIRE(holdsLevelSet(scratch.file("t.vdb")));
    REQUIRE_THROWS_WITH(runConvert(recipeOf(scratch.file("s.stl"), {scratch.file("t.csv")})),
                        Contains("t.csv"));
}

TEST_CASE("the level set of a long and thin shape resolves its thickness") {
    const TemporaryFolder scratch;
    Pack<3> pack;
    pack.spheres = {{{{1, 1, 1}}, 1}};
    writePack(pack, scratch.file("p.csv"), {});
    auto recipe = recipeOf(scratch.file("p.csv"), {scratch.file("p.stl")});
    recipe.domain.source = "box:2,2,1500";
    runConvert(recipe);
    CHECK(checkMesh(readMesh(scratch.file("p.stl"))).enclosedVolume == Approx(6000).epsilon(0.01));
}

TEST_CASE("spheres do not replace the level sets of a .vdb") {
    const TemporaryFolder scratch;
    PackJob recipe = recipeFor("ball:5", "uniform:0.5,1");
    recipe.outputs = {scratch.file("whole.vdb"), scratch.file("points.csv")};
    setVoids(recipe.request, "boolean", "constant:1.5", 0.7);
    runPack(recipe);
    REQUIRE(holdsLevelSet(scratch.file("whole.vdb")));
    CHECK_THROWS_AS(runConvert(recipeOf(scratch.file("points.csv"), {scratch.file("whole.vdb")})),
                    ParameterError);
    CHECK(holdsLevelSet(scratch.file("whole.vdb")));
    const auto told = runConvert(recipeOf(scratch.file("whole.vdb"), {scratch.file("again.vdb")}));
    REQUIRE(told.warnings.size() == 1);
    CHECK_THAT(told.warnings[0], Contains("level sets"));
    CHECK(runConvert(recipeOf(scratch.file("points.csv"), {scratch.file("again.vdb")}))
              .warnings.empty());
}

TEST_CASE("a conversion warns of another body's domain, and counts the pairs that it lists") {
    const TemporaryFolder scratch;
    const auto pack = latticePack<3>(300, {{0, 10, 40}}, 30, 2);
    writePack(pack, scratch.file("p.vtp"), {});
    auto recipe = recipeOf(scratch.file("p.vtp"), {"bonds:" + scratch.file("b.csv")});
    recipe.contactTolerance = recipe.bonds.tolerance = 0.5;
    const auto alone = runConvert(recipe);
    CHECK(alone.warnings.empty());
    CHECK_FALSE(alone.density);
    CHECK(alone.pairs == listContacts(pack.spheres, 0.5).size());
    CHECK_THAT(summary(alone), Contains("pairs") && Contains("0.5"));
    auto soft = pack;
    soft.columns.push_back({"modulus_MPa", std::vector<double>(300), {}, {}});
    writePack(soft, scratch.file("soft.vtp"), {});
    auto contacts = recipeOf(scratch.file("soft.vtp"), {"contacts:" + scratch.file("c.csv")});
    contacts.contactTolerance = contacts.bonds.tolerance = 0.5;
    CHECK(runConvert(contacts).pairs == alone.pairs);
    recipe.outputs = {scratch.file("p.data")};
    const auto heavy = runConvert(recipe);
    CHECK(heavy.density == kDefaultDensity);
    CHECK_THAT(summary(heavy), Contains("1000 kg/m³"));
    recipe.domain.source = "ball:5";
    const auto other = runConvert(recipe).warnings;
    REQUIRE(other.size() == 1);
    CHECK_THAT(other.front(), Contains("ball:5") && Contains("`space`"));
}
