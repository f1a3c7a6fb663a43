// Whole runs are the same to the last bit for any number of threads.
#include "support/generators.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/paths.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/formats/mesh_io.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <variant>

namespace {

const char* const kBones[] = {"femur", "hip", "irregular", "mandible", "skull"};

std::string boneFile(const std::string& name) {
    return kMeshes + "/" + name + ".ply";
}

/// The report without what is allowed to differ.
std::string measuresOf(const RunResult& run) {
    auto report = toJson(run);
    for (const char* key : {"threads", "seconds", "peakMemoryBytes"}) report.erase(key);
    return report.dump(1);
}

/// Runs the recipe with 1, 2, 3 and 8 threads. The spheres must be the same and in the same order,
/// with all that is known of them, and so must the reports and the bytes of the files.
/// @return the first run.
RunResult requireSameForAnyThreads(PackJob recipe) {
    const TemporaryFolder folder;
    recipe.outputs = {folder.file("p.csv"), folder.file("p.ply")};
    std::optional<RunResult> first;
    std::vector<std::string> files;
    for (const int threads : {1, 2, 3, 8}) {
        CAPTURE(recipe.domain.source, threads);
        recipe.threads = threads;
        RunResult run = runPack(recipe);
        std::vector<std::string> written;
        for (const auto& output : recipe.outputs) written.push_back(contentOf(output.file));
        if (!first) {
            first = std::move(run);
            files = std::move(written);
            CHECK(first->passed);
            CHECK(first->report.count > 500);
            continue;
        }
        REQUIRE(run.report.hash == first->report.hash);
        CHECK(measuresOf(run) == measuresOf(*first));
        CHECK((written == files));
    }
    return std::move(*first);
}

PackJob boneRecipe(const std::string& name, double count) {
    PackJob recipe = recipeFor(boneFile(name), "");
    recipe.targetCount = count;
    return recipe;
}

/// A bone as scans leave it: one triangle in twenty is lost, one in twenty looks inward.
TriangleMesh brokenBone(const std::string& name) {
    TriangleMesh mesh = readMesh(boneFile(name));
    RandomStream random(5, 0);
    std::vector<std::array<std::uint32_t, 3>> kept;
    for (auto t : mesh.triangles) {
        const double drawn = random.uniform();
        if (drawn < 0.05) continue;
        if (drawn < 0.1) std::swap(t[1], t[2]);
        kept.push_back(t);
    }
    mesh.triangles = std::move(kept);
    return mesh;
}

}  // namespace

TEST_CASE("a packed bone is the same for any number of threads") {
    requireSameForAnyThreads(boneRecipe("irregular", 4000));
}

TEST_CASE("every bundled bone packs the same for any number of threads", "[.slow]") {
    for (const char* name : kBones) requireSameForAnyThreads(boneRecipe(name, 5000));
}

TEST_CASE("circles are the same for any number of threads") {
    requireSameForAnyThreads(recipeFor("rect:40,30", "uniform:0.3,0.6"));
    PackJob slice = boneRecipe("irregular", 2000);
    slice.domain.slice = 0;
    requireSameForAnyThreads(slice);
}

TEST_CASE("orders and efforts are the same for any number of threads") {
    for (const Order order :
         {Order::sweep, Order::waves, Order::wall, Order::center, Order::fifo}) {
        for (const Effort effort : {Effort::fast, Effort::normal, Effort::dense}) {
            CAPTURE(static_cast<int>(order), static_cast<int>(effort));
            for (const char* domain : {"cylinder:6,15", "rect:30,30"}) {
                PackJob recipe = recipeFor(domain, "uniform:0.4,0.8");
                recipe.packing.order = order;
                recipe.packing.effort = effort;
                recipe.packing.gap = 0.01;
                requireSameForAnyThreads(recipe);
            }
        }
    }
}

TEST_CASE("a bone with voids is the same for any number of threads", "[.slow]") {
    PackJob recipe = boneRecipe("irregular", 4000);
    setVoids(recipe.request, "boolean", "uniform:2,3", 0.4);
    recipe.request.shell = 3;
    recipe.request.keepConnected = true;
    const auto run = requireSameForAnyThreads(recipe);
    CHECK(run.report.voids->culled > 500);
    // Circles in a slice of it, in the same way.
    recipe.targetCount = 2000;
    recipe.domain.slice = 0;
    CHECK(requireSameForAnyThreads(recipe).report.voids->culled > 100);
}

TEST_CASE("a repaired bone is the same for any number of threads", "[.slow]") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor(folder.file("broken.obj"), "");
    recipe.targetCount = 3000;
    recipe.domain.repair = true;
    writeObj(brokenBone("irregular"), recipe.domain.source);
    const auto holes = requireSameForAnyThreads(recipe);
    CHECK(holes.report.domain.repair != nullptr);
    // Holes too large to fill: the surface is rebuilt.
    writeObj(merged(ballMesh(10, 4), ballMesh(6, 4, {{9, 0, 0}})), recipe.domain.source);
    requireSameForAnyThreads(recipe);
}

TEST_CASE("spheres around others are the same for any number of threads") {
    const TemporaryFolder folder;
    PackJob recipe = boneRecipe("irregular", 3000);
    recipe.domain.clips = {parseClip("plane:0,0,1,0")};
    recipe.outputs = {folder.file("half.csv")};
    const auto half = runPack(recipe);
    PackJob whole = recipeFor(boneFile("irregular"), "uniform:0.8,1.2");
    whole.existing = recipe.outputs[0].text;
    const auto run = requireSameForAnyThreads(whole);
    CHECK(run.report.existing == half.report.count);
    CHECK(run.report.count > run.report.existing + 500);
}
