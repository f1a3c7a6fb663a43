// Whatever a pack holds passes through every command.
#include "cli/recipes.h"
#include "support/temporary_folder.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

using namespace vdbpack;
using namespace vdbpack::test;

namespace {

/// What a sphere is called and belongs to.
struct Labels {
    std::int32_t region;
    double modulus;
    std::string part;

    bool operator==(const Labels& other) const {
        return region == other.region && modulus == other.modulus && part == other.part;
    }
};

const Column* columnOf(const Pack<3>& pack, const std::string& name) {
    const auto found = std::find_if(pack.columns.begin(), pack.columns.end(),
                                    [&](const Column& c) { return c.name == name; });
    return found != pack.columns.end() ? &*found : nullptr;
}

/// By id.
std::map<std::int64_t, Labels> labelsOf(const Pack<3>& pack) {
    const Column* moduli = columnOf(pack, "modulus");
    const Column* parts = columnOf(pack, "part");
    REQUIRE(moduli);
    REQUIRE(parts);
    REQUIRE(pack.id.size() == pack.spheres.size());
    REQUIRE(pack.region.size() == pack.spheres.size());
    std::map<std::int64_t, Labels> labels;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        labels[pack.id[i]] = {pack.region[i], moduli->numbers[i], parts->texts[i]};
    return labels;
}

/// A pack of a ball of radius 5 with labels of its own, in a file.
struct Labelled {
    TemporaryFolder folder;
    std::string file, out;
    std::map<std::int64_t, Labels> labels;

    explicit Labelled(const std::string& extension)
        : file(folder.file("in" + extension)), out(folder.file("out" + extension)) {
        Pack<3> pack;
        pack = std::get<Pack<3>>(
            runPack(recipeFor("ball:5", "uniform:0.5,1", folder.file("ball.csv"))).pack);
        Column moduli, parts;
        moduli.name = "modulus";
        parts.name = "part";
        for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
            pack.id.push_back(static_cast<std::int64_t>(5 * i + 3));
            pack.region[i] = static_cast<std::int32_t>(2 + i % 4);
            moduli.numbers.push_back(static_cast<double>(i) / 3);
            parts.texts.push_back(i % 2 != 0 ? "head" : "neck_1");
        }
        pack.columns = {moduli, parts};
        writePack(pack, file);
        labels = labelsOf(pack);
    }
    /// Requires that the spheres of `out` which have ids of the input have its labels.
    /// @return how many they are.
    std::size_t requireLabels() const {
        const auto found = labelsOf(readPack(out));
        std::size_t known = 0;
        for (const auto& [id, label] : found) {
            const auto given = labels.find(id);
            if (given == labels.end()) continue;
            CAPTURE(id, label.region, given->second.region, label.part);
            REQUIRE(label == given->second);
            ++known;
        }
        return known;
    }
};

constexpr const char* kWithColumns[] = {".csv", ".vtp", ".pvtp", ".npz", ".vdb", ".xyz"};

}  // namespace

TEST_CASE("labels and columns pass through convert", "[cli][columns]") {
    const Labelled given(GENERATE(from_range(std::begin(kWithColumns), std::end(kWithColumns))));
    ConvertRecipe recipe;
    recipe.pack = given.file;
    recipe.outputs = {given.out};
    runConvert(recipe);
    REQUIRE(given.requireLabels() == given.labels.size());
}

TEST_CASE("existing spheres keep their labels and columns, with a shell and voids too",
          "[cli][columns]") {
    const Labelled given(GENERATE(from_range(std::begin(kWithColumns), std::end(kWithColumns))));
    PackJob recipe = recipeFor("box:14,14,14", "uniform:0.5,1", given.out);
    recipe.existing = given.file;
    const bool cut = GENERATE(false, true);
    CAPTURE(given.file, cut);
    if (cut) {
        recipe.request.shell = 2;
        recipe.request.method = "boolean";
        recipe.request.radius = "constant:1";
        recipe.request.targetBvtv = 0.7;
    }
    const auto run = runPack(recipe);
    REQUIRE(given.requireLabels() == given.labels.size());
    const auto pack = readPack(given.out);
    REQUIRE(pack.spheres.size() > given.labels.size() + 100);
    // New spheres have regions of this run.
    std::size_t cortical = 0, trabecular = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        if (given.labels.count(pack.id[i]) != 0) continue;
        cortical += pack.region[i] == 0 ? 1 : 0;
        trabecular += pack.region[i] == 1 ? 1 : 0;
    }
    REQUIRE(cortical + trabecular == pack.spheres.size() - given.labels.size());
    REQUIRE(cortical > 0);
    REQUIRE((trabecular > 0) == cut);
}

TEST_CASE(
    "carved spheres keep their labels and columns; with a shell the regions are those of the run",
    "[cli][columns]") {
    const Labelled given(GENERATE(from_range(std::begin(kWithColumns), std::end(kWithColumns))));
    CAPTURE(given.file);
    CarveJob recipe;
    recipe.pack = given.file;
    recipe.domain.source = "ball:5";
    recipe.outputs = {given.out};
    recipe.request.method = "boolean";
    recipe.request.radius = "constant:1";
    recipe.request.targetBvtv = 0.6;
    const auto run = runCarve(recipe);
    REQUIRE(run.report.voids->culled > 5);
    REQUIRE(given.requireLabels() == given.labels.size() - run.report.voids->culled);
    recipe.request.shell = 1;
    runCarve(recipe);
    const auto shelled = readPack(given.out);
    REQUIRE(*std::max_element(shelled.region.begin(), shelled.region.end()) == 1);
}

TEST_CASE("spheres without ids keep the names that their places gave them when others are carved",
          "[cli][columns]") {
    const TemporaryFolder folder;
    runPack(recipeFor("ball:5", "uniform:0.5,1", folder.file("in.csv")));
    CarveJob recipe;
    recipe.pack = folder.file("in.csv");
    recipe.domain.source = "ball:5";
    recipe.outputs = {folder.file("out.csv")};
    recipe.request.method = "boolean";
    recipe.request.radius = "constant:1";
    recipe.request.targetBvtv = 0.6;
    runCarve(recipe);
    const auto before = readPack(folder.file("in.csv"));
    const auto after = readPack(folder.file("out.csv"));
    REQUIRE(after.id.size() == after.spheres.size());
    REQUIRE(after.spheres.size() < before.spheres.size());
    for (std::size_t i = 0; i < after.id.size(); ++i)
        REQUIRE(after.spheres[i] == before.spheres[static_cast<std::size_t>(after.id[i])]);
}

TEST_CASE("densified spheres keep their labels and columns", "[cli][columns]") {
    const Labelled given(GENERATE(from_range(std::begin(kWithColumns), std::end(kWithColumns))));
    CAPTURE(given.file);
    DensifyRecipe recipe;
    recipe.pack = given.file;
    recipe.domain.source = "ball:5";
    recipe.outputs = {given.out};
    recipe.densify.fraction = 0.01;  // overlaps alone
    runDensify(recipe);
    REQUIRE(given.requireLabels() == given.labels.size());
}
