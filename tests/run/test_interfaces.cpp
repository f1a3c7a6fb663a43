// Where parts meet: area, bonds per area beside those of the bulk, and the warning of a weak plane.
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/text_file.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/run/part_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

namespace {

PackRecipe boxPart(const std::string& file, const Box<3>& box, const char* name) {
    writeStl(boxMesh(box), file, Unit::millimeter, "test");
    PackRecipe part = recipeFor(file, "uniform:0.3,0.6");
    part.name = name;
    return part;
}

/// A box, and one that reaches into it: five of its faces lie there in whole or in part.
PackRecipe boxAndPeg(const TemporaryFolder& folder) {
    PackRecipe recipe;
    recipe.parts = {boxPart(folder.file("a.stl"), {{{0, 0, 0}}, {{10, 10, 10}}}, "bone"),
                    boxPart(folder.file("b.stl"), {{{5, 2, 2}}, {{15, 8, 8}}}, "peg")};
    recipe.outputs = {"bonds:" + folder.file("bonds.csv"),
                      "interfaces:" + folder.file("interfaces.csv")};
    return recipe;
}

/// The tolerance that a warning names.
double advised(const std::string& warning) {
    const std::string name = "`interfaceTolerance` ";
    const auto at = warning.find(name);
    REQUIRE(at != std::string::npos);
    return std::stod(warning.substr(at + name.size()));
}

}  // namespace

TEST_CASE("an interface has its area and its bonds beside those of the parts") {
    const TemporaryFolder folder;
    PackRecipe recipe = boxAndPeg(folder);
    const RunResult run = runPack(recipe);
    REQUIRE(run.report.interfaces.size() == 1);
    const InterfaceReport& weak = run.report.interfaces.front();
    CHECK(weak.parts == std::array<std::string, 2>{"bone", "peg"});
    CHECK(weak.area == Approx(6 * 6 + 4 * 5 * 6).epsilon(0.02));
    CHECK(weak.perArea() < 0.5 * std::min(weak.bulk[0], weak.bulk[1]));
    std::string warned;
    for (const std::string& text : run.report.warnings)
        if (text.find("weak plane") != std::string::npos) warned = text;
    CHECK_THAT(warned, Contains("bone and peg"));
    // The tolerance that it names is the remedy.
    recipe.bonds.interfaceTolerance = advised(warned);
    const RunResult mended = runPack(recipe);
    const InterfaceReport& strong = mended.report.interfaces.front();
    const double bulk = std::min(strong.bulk[0], strong.bulk[1]);
    CHECK(strong.perArea() >= 0.99 * bulk);
    CHECK(strong.perArea() <= 1.5 * bulk);
    for (const std::string& text : mended.report.warnings)
        CHECK_THAT(text, !Contains("weak plane"));
    CHECK(mended.report.hash == run.report.hash);
    const std::string table = contentOf(folder.file("interfaces.csv"));
    CHECK_THAT(table, Contains(fmt::format("\nbone,peg,{},", strong.pairs)));
    // So does a conversion, which has to be given it.
    ConvertRecipe convert;
    convert.pack = folder.file("p.vtp");
    writePack(std::get<Pack<3>>(run.pack), convert.pack);
    convert.outputs = {"bonds:" + folder.file("again.csv")};
    const auto loose = runConvert(convert).warnings;
    REQUIRE(loose.size() == 1);
    CHECK_THAT(loose.front(), Contains("bone and peg") && Contains("`interfaceTolerance`"));
    CHECK(advised(loose.front()) == Approx(advised(warned)).epsilon(0.15));
    convert.bonds = recipe.bonds;
    CHECK(runConvert(convert).warnings.empty());
    CHECK(contentOf(folder.file("again.csv")) == contentOf(folder.file("bonds.csv")));
    recipe.parts.pop_back();
    recipe = std::move(recipe.parts.front());
    recipe.outputs = {"interfaces:" + folder.file("none.csv")};
    CHECK_THROWS_WITH(runPack(recipe), Contains("partsFile"));
}

TEST_CASE("an interface has its area where triangles are larger than it") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.parts = {boxPart(folder.file("a.stl"), {{{0, 0, 0}}, {{9, 9, 6}}}, "low"),
                    boxPart(folder.file("b.stl"), {{{6, 5, 6}}, {{15, 14, 12}}}, "high")};
    recipe.outputs = {"interfaces:" + folder.file("interfaces.csv")};
    const auto found = runPack(recipe).report.interfaces;
    REQUIRE(found.size() == 1);
    CHECK(found.front().area == Approx(3 * 4).epsilon(0.1));
}

TEST_CASE("spheres alone tell the volume of parts and the area between them") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.parts = {boxPart(folder.file("a.stl"), {{{0, 0, 0}}, {{18, 18, 10}}}, "low"),
                    boxPart(folder.file("b.stl"), {{{6, 5, 10}}, {{22, 20, 24}}}, "high")};
    const auto pack = std::get<Pack<3>>(runPack(recipe).pack);
    const PartSpace space = spaceOfParts(pack, Materials(pack));
    CHECK(space.volume.at(0) == Approx(18 * 18 * 10).epsilon(0.1));
    CHECK(space.volume.at(1) == Approx(16 * 15 * 14).epsilon(0.1));
    REQUIRE(space.area.size() == 1);
    CHECK(space.area.at({0, 1}) == Approx(12 * 13).epsilon(0.1));
}

TEST_CASE("a part within one that is listed later has to come after it") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.parts = {boxPart(folder.file("a.stl"), {{{3, 3, 3}}, {{6, 6, 6}}}, "screw"),
                    boxPart(folder.file("b.stl"), {{{0, 0, 0}}, {{10, 10, 10}}}, "bone")};
    recipe.outputs = {folder.file("p.csv")};
    CHECK_THROWS_WITH(runPack(recipe),
                      Contains("screw: lies within") && Contains("list it after them"));
    std::swap(recipe.parts[0], recipe.parts[1]);
    const RunResult first = runPack(recipe);
    CHECK(first.report.parts.size() == 2);
    recipe.seed = 9;
    CHECK(runPack(recipe).report.hash != first.report.hash);
    // Half of it, and none shares its radii.
    const auto warned = [&](const char* words) {
        const auto& all = runPack(recipe).report.warnings;
        return std::any_of(all.begin(), all.end(), [&](const std::string& text) {
            return text.find(words) != std::string::npos;
        });
    };
    recipe.parts[1] = boxPart(folder.file("c.stl"), {{{3, 3, 7}}, {{6, 6, 13}}}, "screw");
    CHECK_FALSE(warned("list it after"));
    std::swap(recipe.parts[0], recipe.parts[1]);
    CHECK(warned("screw: 50 % of its volume left to later parts, such as bone"));
    CHECK_FALSE(warned("has no effect"));
    recipe.targetCount = 500;
    for (PackRecipe& part : recipe.parts) part.targetCount = 500;
    CHECK(warned("`targetCount` 500 has no effect"));
}

TEST_CASE("a part that was moved away from all others is named") {
    const TemporaryFolder folder;
    PackRecipe recipe = boxAndPeg(folder);
    recipe.parts[1].domain.pose.translate = GENERATE(Vec<3>{{0, 0, 0}}, Vec<3>{{100, 0, 0}});
    const bool away = (*recipe.parts[1].domain.pose.translate)[0] > 0;
    const RunResult run = runPack(recipe);
    CHECK(run.report.interfaces.size() == (away ? 0 : 1));
    const auto names = [](const std::string& text) {
        return text.find("peg: touches no other part") != std::string::npos;
    };
    const auto& warnings = run.report.warnings;
    CHECK(std::any_of(warnings.begin(), warnings.end(), names) == away);
}

TEST_CASE("a plane through a part cuts as many bonds as its count says") {
    const TemporaryFolder folder;
    PackRecipe recipe = boxAndPeg(folder);
    recipe.contactTolerance = 0.1;
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    const auto& part = pack.columns.front().numbers;
    // Planes of all three directions, away from the peg and from the walls.
    double cut = 0, area = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (double height = axis == 0 ? 1.5 : 1; height < (axis == 0 ? 4 : 2); height += 0.1) {
            for (const Contact& c : listContacts(pack.spheres, 0.1)) {
                const double a = pack.spheres[c.i].center[axis], b = pack.spheres[c.j].center[axis];
                cut += part[c.i] == 0 && part[c.j] == 0 && (a < height) != (b < height);
            }
            area += 100;
        }
    CHECK(run.report.interfaces.front().bulk[0] == Approx(cut / area).epsilon(0.15));
}

TEST_CASE("labels that touch have the area of the voxels between them") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd");
    writeHalves(file);
    PackRecipe recipe;
    recipe.domain.source = file;
    recipe.domain.label = "all";
    recipe.targetCount = 1000;
    const RunResult run = runPack(recipe);
    REQUIRE(run.report.interfaces.size() == 1);
    // A ball of radius 12 mm in two halves.
    CHECK(run.report.interfaces.front().area == Approx(std::acos(-1.0) * 144).epsilon(0.05));
}

TEST_CASE("one pack over two labels has as many bonds across their border as anywhere") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.domain.source = folder.file("halves.nrrd");
    writeHalves(recipe.domain.source);
    recipe.domain.label = "9,5";
    recipe.domain.partsBy = PartsBy::center;
    recipe.radius = SizeRequest::parse("uniform:0.3,0.6");
    recipe.contactTolerance = recipe.bonds.tolerance = 0.05;
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    const auto& part = pack.columns.front();
    CHECK(part.names == std::vector<std::string>{"9", "5"});
    // The border of the labels, and planes beside it, through a ball of radius 12.
    const Vec<3> normal = normalized(Vec<3>{{1, 0, 0.5}});
    const double border = 1 / std::sqrt(1.25);
    const auto depthOf = [&](std::size_t i) { return dot(normal, pack.spheres[i].center); };
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        if (std::fabs(depthOf(i) - border) > 1)
            CHECK(part.numbers[i] == (depthOf(i) > border ? 0 : 1));
    const auto bonds = listContacts(pack.spheres, recipe.contactTolerance);
    const auto across = [&](double at) {
        const auto crosses = [&](const Contact& c) {
            return (depthOf(c.i) > at) != (depthOf(c.j) > at);
        };
        return static_cast<double>(std::count_if(bonds.begin(), bonds.end(), crosses)) /
               Measure<2>::ball(std::sqrt(144 - at * at));
    };
    const double elsewhere = (across(-3) + across(-1.5) + across(3) + across(4.5)) / 4;
    REQUIRE(run.report.interfaces.size() == 1);
    const InterfaceReport& found = run.report.interfaces.front();
    CHECK(found.perArea() == Approx(elsewhere).epsilon(0.1));
    CHECK(found.pairs == run.report.contactsBetweenParts);
    for (const std::string& text : run.report.warnings) CHECK_THAT(text, !Contains("weak plane"));
    // The same spheres as over both labels joined, each in one part.
    recipe.domain.partsBy = PartsBy::none;
    recipe.domain.label = "5+9";
    CHECK(runPack(recipe).report.hash == run.report.hash);
    CHECK(run.report.parts[0].count + run.report.parts[1].count == run.report.count);
    recipe.domain.partsBy = PartsBy::center;
    CHECK_THROWS_AS(runPack(recipe), ParameterError);
}
