// Packs far from the origin and in other units are as good as those about it.
#include "support/generators.h"
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/paths.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_check.h"

namespace {

struct Moved {
    double scale, far;
    Unit unit;
};
const Moved kMoved[] = {{1, 0, Unit::millimeter},   {1, 1e4, Unit::millimeter},
                        {1, 1e6, Unit::millimeter}, {1e-3, 0, Unit::meter},
                        {1e3, 0, Unit::micrometer}, {1e-3, 1e4, Unit::meter}};

/// Packs `mesh` moved and in other units; each must reach the same and pass after it was read.
void checkMoved(const TriangleMesh& mesh, const std::string& radius, double target,
                double tolerance) {
    const TemporaryFolder folder;
    double first = 0;
    for (const Moved& moved : kMoved) {
        CAPTURE(moved.scale, moved.far);
        TriangleMesh there = mesh;
        for (auto& v : there.vertices)
            for (double& c : v.c) c = (c + moved.far) * moved.scale;
        const std::string file = folder.file("m.obj");
        writeObj(there, file);
        PackRecipe recipe = recipeFor(file, radius);
        recipe.targetCount = target;
        recipe.domain.unit = moved.unit;
        for (const char* name :
             {"p.vdb", "p.csv", "p.vtp", "q.pvtp", "p.vtkhdf", "p.npz", "p.ply", "p.xyz", "p.data"})
            recipe.outputs.push_back(folder.file(name));
        recipe.outputs.push_back("yade:" + folder.file("p.txt"));
        const auto run = runPack(recipe);
        REQUIRE(run.passed);
        const double total = run.report.solidFractionTotal.value();
        if (first == 0) first = total;
        CHECK(total == Approx(first).margin(tolerance));
        for (const auto& output : recipe.outputs) {
            CAPTURE(output.text);
            auto verify = onPack<VerifyRecipe>(output.text);
            verify.domain = recipe.domain;
            const auto checked = runVerify(verify);
            CHECK(checked.passed);
            CHECK(checked.report.overlap->max == 0);
            CHECK(checked.report.protrusion->max == 0);
            CHECK(checked.report.hash == run.report.hash);
        }
    }
}

}  // namespace

TEST_CASE("a ball packs as well far away and in meters or micrometers") {
    checkMoved(ballMesh(10, 3), "uniform:0.8,1.6", 0, 0.015);
}

TEST_CASE("a mandible packs as well far away and in meters or micrometers", "[.slow]") {
    const auto mesh = readMesh(kMeshes + "/mandible.ply");
    checkMoved(mesh, "", 30000, 0.003);
}

TEST_CASE("a pack lies within the .stl that its run wrote, far from the origin and in any unit") {
    const TemporaryFolder folder;
    ImageGrid grid = gridAround(12, {{0.7, 0.8, 0.9}});
    const auto labels = Voxels<std::uint8_t>::of(grid, [](const Vec<3>& p) {
        return length(p - Vec<3>{{-3, 0, 0}}) < 7 || (p[0] > 4.2 && p[1] > 0 && length(p) < 11) ||
               (p[0] < 4.2 && p[1] < -6 && length(p) < 11);
    });
    auto there = labels;
    there.grid.origin += Vec<3>{{-183.3, 412.7, -871.9}};
    writeNrrd(folder.file("l.nrrd"), there, "uint8");
    const bool isLabelMap = GENERATE(true, false);
    if (!isLabelMap)
        writeObj(translated(ballMesh(9, 4), {{-183.3, 412.7, -871.9}}), folder.file("b.obj"));
    for (const Unit unit : {Unit::millimeter, Unit::meter, Unit::micrometer}) {
        PackRecipe recipe =
            recipeFor(folder.file(isLabelMap ? "l.nrrd" : "b.obj"), "uniform:0.5,1");
        recipe.outUnit = unit;
        recipe.outputs = {folder.file("p.vtp"), folder.file("s.stl")};
        REQUIRE(runPack(recipe).passed);
        const auto checked =
            runVerify(onPack<VerifyRecipe>(folder.file("p.vtp"), folder.file("s.stl")));
        CAPTURE(isLabelMap, unitName(unit));
        CHECK(checked.passed);
        CHECK(checked.report.protrusion->max == 0);
        CHECK(checked.report.count > 500);
        // Other commands take the surface, too.
        MeshRecipe mesh;
        mesh.domain.source = folder.file("s.stl");
        CHECK(runMesh(mesh).fitness.verdict == MeshFitness::Verdict::yes);
        CHECK(runPack(recipeFor(folder.file("s.stl"), "uniform:0.5,1")).passed);
    }
}

TEST_CASE("the .stl of an image's surface makes the same pack as the image") {
    const TemporaryFolder folder;
    ImageGrid grid = gridAround(9, {{0.7, 0.8, 0.9}});
    grid.origin += Vec<3>{{-183.3, 412.7, -871.9}};
    // Voxels with just the threshold, pores and specks of one voxel, voxels that meet at an edge.
    RandomStream random(5, 1);
    const bool isLabelMap = GENERATE(true, false);
    const auto voxels = Voxels<std::int16_t>::of(grid, [&](const Vec<3>& p) {
        const double depth = 8 - length(p - Vec<3>{{-183.3, 412.7, -871.9}});
        const double noise = random.uniform() < 0.03 ? 9 * random.uniform() - 4.5 : 0;
        const double value = std::floor(std::clamp(depth, -2.0, 2.0) + noise);
        return isLabelMap ? value >= 0 : 100 * value;
    });
    writeNrrd(folder.file("v.nrrd"), voxels, "int16");
    auto recipe = recipeFor(folder.file("v.nrrd"), "uniform:0.3,0.6");
    if (!isLabelMap) recipe.domain.threshold = 0;
    recipe.outputs = {folder.file("s.stl")};
    const auto made = runPack(recipe);
    CAPTURE(isLabelMap);
    CHECK(made.report.count > 1000);
    const MeshHealth health = checkMesh(readMesh(folder.file("s.stl")));
    CHECK(health.pieces > 10);
    CHECK(health.isWatertight());
    CHECK(health.intersections == 0);
    CHECK(health.degenerateTriangles == 0);
    CHECK(runPack(recipeFor(folder.file("s.stl"), "uniform:0.3,0.6")).report.hash ==
          made.report.hash);
}

TEST_CASE("a pack of what voids leave lies within the .stl of that solid") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("box:190,400,870,198,408,878", "uniform:0.08,0.16");
    recipe.request.fill = Fill::solid;
    setVoids(recipe.request, "boolean", "uniform:0.7,1", 0.3);
    recipe.outputs = {folder.file("p.vtp"), folder.file("s.stl")};
    REQUIRE(runPack(recipe).passed);
    const auto checked =
        runVerify(onPack<VerifyRecipe>(folder.file("p.vtp"), folder.file("s.stl")));
    CHECK(checked.report.count > 5000);
    CHECK(checked.report.protrusion->max < 1e-6);
}

TEST_CASE("a pack in a thin box lies within the .stl of that box") {
    const TemporaryFolder folder;
    PackRecipe recipe = recipeFor("box:0.6,6,6", "uniform:0.1,0.2");
    recipe.outputs = {folder.file("p.vtp"), folder.file("s.stl")};
    runPack(recipe);
    CHECK(checkMesh(readMesh(folder.file("s.stl"))).enclosedVolume == Approx(0.6 * 36));
    CHECK(runVerify(onPack<VerifyRecipe>(folder.file("p.vtp"), folder.file("s.stl"))).passed);
}

TEST_CASE("a unit that a level set of a run states is used when it is read") {
    const TemporaryFolder folder;
    PackRecipe recipe = recipeFor("box:20,24,28", "uniform:2,3");
    recipe.outUnit = GENERATE(Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer);
    recipe.outputs = {"levelsets:" + folder.file("p.vdb"), "fog:" + folder.file("f.vdb")};
    runPack(recipe);
    DomainRecipe read;
    read.source = folder.file("p.vdb");
    read.unit = GENERATE(Unit::millimeter, Unit::meter);
    CHECK(DomainSource(read).volume() == Approx(20 * 24 * 28).epsilon(0.01));
    read.source = folder.file("f.vdb");
    read.threshold = 0.01;
    CHECK(DomainSource(read).volume() == Approx(20 * 24 * 28).epsilon(0.03));
}

TEST_CASE("lengths that a pack cannot be made with are refused with the value and the remedy") {
    const TemporaryFolder folder;
    writeObj(ballMesh(10, 3), folder.file("m.obj"));
    PackRecipe levelSet = recipeFor("ball:10", "constant:2", "levelsets:" + folder.file("v.vdb"));
    runPack(levelSet);
    writeNrrd(folder.file("i.nrrd"),
              Voxels<std::uint8_t>::of(gridAround(5, {{1, 1, 1}}),
                                       [](const Vec<3>& p) { return length(p) < 4; }),
              "uint8");
    const auto refusal = [](const std::string& domain, double scale, const std::string& radius) {
        return messageOf<Error>([&] {
            PackRecipe recipe = recipeFor(domain, radius);
            recipe.domain.scale = scale;
            runPack(recipe);
        });
    };
    for (const char* file : {"m.obj", "v.vdb", "i.nrrd"})
        for (const double scale : {1e-9, 1e-5, 1e7}) {
            CAPTURE(file, scale);
            CHECK_THAT(refusal(folder.file(file), scale, "constant:1"),
                       Contains(file) && Contains("mm") && Contains("`unit`"));
        }
    for (const char* domain : {"box:20,20,20", "ball:10", "rect:20,20"})
        for (const char* radius : {"constant:1e-08", "uniform:1,1000000"}) {
            CAPTURE(domain, radius);
            CHECK_THAT(refusal(domain, 1, radius),
                       Contains(radius) && Contains("1e-7 to 1e5 mm") && Contains("`scale`"));
        }
}
