// Packs of several parts: labels of an image, and meshes that overlap.
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/preview/preview.h"

#include <fmt/format.h>

namespace {

std::vector<double> partsIn(const Pack<3>& pack) {
    for (const Column& column : pack.columns)
        if (column.name == kPartColumn) return column.numbers;
    return {};
}

/// The spheres of one part.
std::vector<Sphere<3>> spheresOf(const Pack<3>& pack, std::int32_t part) {
    std::vector<Sphere<3>> spheres;
    const auto parts = partsIn(pack);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        if (parts[i] == part) spheres.push_back(pack.spheres[i]);
    return spheres;
}

PackRecipe meshPart(const std::string& file, const Box<3>& box, const char* name) {
    writeStl(boxMesh(box), file, Unit::millimeter, "test");
    PackRecipe part = recipeFor(file, "uniform:0.5,1");
    part.name = name;
    return part;
}

}  // namespace

TEST_CASE("labels of an image are packed as parts that no sphere crosses") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd");
    writeHalves(file);
    PackRecipe recipe;
    recipe.domain.source = file;
    recipe.domain.label = "all";
    recipe.targetCount = 3000;
    recipe.contactTolerance = 0.1;
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    REQUIRE(run.report.parts.size() == 2);
    CHECK(run.report.contactsBetweenParts > 5);
    CHECK(run.passed);
    CHECK(run.report.count == pack.spheres.size());
    CHECK(static_cast<double>(run.report.count) == Approx(3000).epsilon(0.1));
    CHECK(run.report.parts[0].requested == run.report.parts[1].requested);
    CHECK(run.report.hash == packHash(pack));
    CHECK(checkOverlap(pack.spheres).pairs == 0);

    CHECK(partNames(pack) == std::vector<std::string>{"5", "9"});
    writePack(pack, folder.file("p.vtp"));
    auto verify = onPack<VerifyRecipe>(folder.file("p.vtp"));
    verify.domain = recipe.domain;
    verify.contactTolerance = 0.1;
    const RunResult checked = runVerify(verify);
    CHECK(checked.passed);
    REQUIRE(checked.report.parts.size() == 2);
    CHECK(checked.report.parts[1].count == run.report.parts[1].count);
    CHECK(checked.report.contacts->mean == Approx(run.report.contacts->mean).epsilon(1e-3));
    CHECK(checked.report.contacts->wallContacts > 0);
    CHECK(checked.report.contactsBetweenParts == run.report.contactsBetweenParts);
    // Each sphere is held against its own part.
    Pack<3> exchanged = pack;
    for (double& part : exchanged.columns.front().numbers) part = 1 - part;
    writePack(exchanged, folder.file("p.vtp"));
    const RunResult wrong = runVerify(verify);
    CHECK_FALSE(wrong.passed);
    CHECK(wrong.report.protrusion->spheres > 2500);
    exchanged.columns.front().numbers[7] = 2;
    writePack(exchanged, folder.file("p.vtp"));
    CHECK_THROWS_AS(runVerify(verify), InputError);
    exchanged.columns.clear();
    writePack(exchanged, folder.file("p.vtp"));
    CHECK_THAT(messageOf<InputError>([&] { runVerify(verify); }), Contains("`part`"));

    const Image image = readImage(file);
    const auto labels = *labelsOf(image);
    const auto meshes = labelSurfaces(image, labels, parseLabels("all", labels, file));
    for (std::int32_t part = 0; part < 2; ++part) {
        const auto spheres = spheresOf(pack, part);
        CHECK(spheres.size() == run.report.parts[static_cast<std::size_t>(part)].count);
        CHECK(spheres.size() > 500);
        CHECK(checkProtrusion(spheres, meshes[static_cast<std::size_t>(part)]).spheres == 0);
    }
    const double volume = 4.0 / 3 * std::acos(-1.0) * 1728;
    CHECK(run.report.volume == Approx(volume).epsilon(0.01));
    recipe.domain.label = "5,9";
    CHECK(runPack(recipe).report.hash == run.report.hash);
}

TEST_CASE("a segment of another layer has the space of those below it") {
    const TemporaryFolder folder;
    // Two layers of one value each, as 3D Slicer writes overlapping segments.
    const ImageGrid grid = gridAround(10, {{1, 1, 1}});
    std::string values;
    const auto inBall = [](const Vec<3>& p, double x) { return length(p - Vec<3>{{x, 0, 0}}) < 6; };
    const auto low = Voxels<std::uint8_t>::of(grid, [&](const Vec<3>& p) { return inBall(p, -2); });
    const auto high = Voxels<std::uint8_t>::of(grid, [&](const Vec<3>& p) { return inBall(p, 3); });
    for (std::size_t i = 0; i < low.values.size(); ++i) {
        values += static_cast<char>(low.values[i]);
        values += static_cast<char>(high.values[i]);
    }
    const std::string n = std::to_string(grid.size[0]), file = folder.file("two.seg.nrrd");
    writeBytes(
        file, "NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 " + n +
                  ' ' + n + ' ' + n +
                  "\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
                  "kinds: list domain domain domain\nencoding: raw\nspace origin: (" +
                  std::to_string(grid.origin[0]) + ',' + std::to_string(grid.origin[1]) + ',' +
                  std::to_string(grid.origin[2]) + ")\n\n" + values);
    PackRecipe recipe = recipeFor(file, "uniform:0.4,0.8");
    recipe.domain.label = "all";
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    CHECK(run.passed);
    REQUIRE(run.report.parts.size() == 2);
    const double ball = 4.0 / 3 * std::acos(-1.0) * 216;
    CHECK(run.report.parts[1].volume == Approx(ball).epsilon(0.03));
    CHECK(run.report.parts[0].volume < 0.75 * ball);
    CHECK(checkOverlap(pack.spheres).pairs == 0);
}

TEST_CASE("labels joined by + are one domain") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd");
    writeHalves(file);
    PackRecipe recipe = recipeFor(file, "uniform:0.6,1.2");
    recipe.domain.label = "9+5";
    const RunResult run = runPack(recipe);
    CHECK(run.report.parts.empty());
    CHECK(run.report.volume == Approx(4.0 / 3 * std::acos(-1.0) * 1728).epsilon(0.01));
    recipe.domain.label.clear();
    CHECK_THAT(messageOf<ParameterError>([&] { runPack(recipe); }), Contains("2 labels"));
    recipe.domain.label = "5,5+9";
    CHECK_THROWS_AS(runPack(recipe), ParameterError);
}

TEST_CASE("where meshes overlap, the later part has the space") {
    const TemporaryFolder folder;
    // A stem that sticks out of a bone.
    const Box<3> bone{{{0, 0, 0}}, {{20, 18, 30}}}, stem{{{7, 6, 12}}, {{13, 12, 42}}};
    PackRecipe recipe;
    recipe.parts = {meshPart(folder.file("bone.stl"), bone, "bone"),
                    meshPart(folder.file("stem.stl"), stem, "stem")};
    recipe.parts[1].density = "4430";
    recipe.parts[0].density = "1800";
    recipe.outputs = {folder.file("p.data"), "yade:" + folder.file("p.txt"), folder.file("p.vtp"),
                      folder.file("p.vdb"), "contacts:" + folder.file("c.csv")};
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    CHECK(run.passed);
    REQUIRE(run.report.parts.size() == 2);
    CHECK(run.report.parts[0].volume == Approx(20 * 18 * 30 - 6 * 6 * 18).epsilon(0.01));
    CHECK(run.report.parts[1].volume == Approx(6 * 6 * 30));
    CHECK(run.report.parts[0].solidFraction > 0.5);
    for (const auto& s : spheresOf(pack, 0))
        CHECK(std::sqrt(stem.squaredDistance(s.center)) >= s.radius * (1 - 1e-9));
    for (const auto& s : spheresOf(pack, 1))
        for (int d = 0; d < 3; ++d) {
            CHECK(s.center[d] - s.radius >= stem.lo[d] - 1e-9);
            CHECK(s.center[d] + s.radius <= stem.hi[d] + 1e-9);
        }
    // The front comes to the stem.
    CHECK(std::any_of(pack.spheres.begin(), pack.spheres.end(), [&](const Sphere<3>& s) {
        return std::fabs(std::sqrt(stem.squaredDistance(s.center)) - s.radius) < 1e-6;
    }));

    const Pack<3> atoms = readPack(folder.file("p.data")), points = readPack(folder.file("p.vtp"));
    const auto parts = partsIn(pack);
    CHECK(partsIn(points) == parts);
    CHECK(points.spheres == pack.spheres);
    CHECK(partsIn(readPack(folder.file("p.vdb"))) == parts);
    CHECK(partsIn(atoms) == parts);
    const Column* density = columnOfNumbers(atoms, kDensityColumn);
    REQUIRE(density);
    for (std::size_t i = 0; i < parts.size(); ++i)
        CHECK(density->numbers[i] == Approx(parts[i] == 0 ? 1800 : 4430));
    CHECK_THAT(contentOf(folder.file("c.csv")), Contains("part_i,part_j"));
    const Pack<3> yade = readPack("yade:" + folder.file("p.txt"));
    CHECK(partsIn(yade) == parts);
}

TEST_CASE("a file lists parts with options of their own") {
    const TemporaryFolder folder;
    meshPart(folder.file("bone.stl"), {{{0, 0, 0}}, {{20, 18, 30}}}, "bone");
    meshPart(folder.file("stem.stl"), {{{7, 6, 12}}, {{13, 12, 42}}}, "stem");
    const std::string file = folder.file("parts.toml");
    writeBytes(file,
               "[[part]]\nname = 'bone'\ndomain = 'bone.stl'\nshell = 4\ndensity = '0=1900,1=900'\n"
               "\n[[part]]\nname = 'stem'\ndomain = 'stem.stl'\nradius = 'constant:0.9'\n");
    const std::string report = folder.file("r.json");
    const Output output = vdbPack("pack --parts " + file + " --radius uniform:0.5,1 --quiet -o " +
                                  folder.file("p.data") + " --report " + report);
    CAPTURE(output.text);
    REQUIRE(output.code == 0);
    const auto json = nlohmann::json::parse(contentOf(report));
    REQUIRE(json["parts"].size() == 2);
    CHECK(json["parts"][0]["name"] == "bone");
    CHECK(json["parts"][0]["densities"] == nlohmann::json{{"0", 1900.0}, {"1", 900.0}});
    CHECK(json["parts"][0]["requested"] == "uniform:0.5,1");
    CHECK(json["parts"][1]["requested"] == "constant:0.9");
    // Regions of each part are materials of their own.
    CHECK_THAT(contentOf(folder.file("p.data")),
               Contains("2 part + region") && Contains("3 atom types"));
    const Output again =
        vdbPack("pack --config " + folder.file("p.recipe.toml") + " --quiet --json");
    REQUIRE(again.code == 0);

    for (const char* bad :
         {"[[part]]\nname = 'x'\n", "part = 3\n", "[[part]]\ndomain = 'bone.stl'\nradios = 1\n",
          "[[part]]\ndomain = \n", ""}) {
        writeBytes(file, bad);
        const Output refused = vdbPack("pack --parts " + file + " --quiet");
        CAPTURE(bad, refused.text);
        CHECK((refused.code == 2 || refused.code == 3));
        CHECK_THAT(refused.text, Contains("parts.toml"));
    }
    CHECK(vdbPack("pack --parts " + folder.file("absent.toml")).code == 4);
}

TEST_CASE("an implant in its own frame is moved into the bone, and its recipe repeats the run") {
    const TemporaryFolder folder;
    meshPart(folder.file("bone.stl"), {{{0, 0, 0}}, {{20, 18, 30}}}, "bone");
    meshPart(folder.file("stem.stl"), {{{-3, -3, 0}}, {{3, 3, 30}}}, "stem");
    meshPart(folder.file("placed.stl"), {{{7, 6, 12}}, {{13, 12, 42}}}, "stem");
    const auto parts = [&](const char* name, const std::string& stem) {
        writeBytes(folder.file(name),
                   "[[part]]\nname = 'bone'\ndomain = 'bone.stl'\n[[part]]\n"
                   "name = 'stem'\n" +
                       stem);
        return " --parts " + folder.file(name);
    };
    const std::string common = " --radius uniform:0.7,1.2 --quiet --json -o ";
    const std::string moved =
        parts("moved.toml", "domain = 'stem.stl'\ntranslate = [10, 9, 1.2e1]\n");
    const auto placed = jsonOf(vdbPack("pack" + parts("placed.toml", "domain = 'placed.stl'\n") +
                                       common + folder.file("a.vtp")));
    const auto run = jsonOf(vdbPack("pack" + moved + common + folder.file("b.vtp")));
    CHECK(run["hash"] == placed["hash"]);
    CHECK(run["parts"][0]["count"] == placed["parts"][0]["count"]);
    CHECK(vdbPack("verify " + folder.file("b.vtp") + moved).code == 0);
    const std::string alone = parts("alone.toml", "domain = 'stem.stl'\n");
    CHECK(vdbPack("verify " + folder.file("b.vtp") + alone).code != 0);

    // Of one domain: the recipe names the file by its own folder.
    writeBytes(folder.file("t.tfm"),
               "#Insight Transform File V1.0\nTransform: AffineTransform_double_3_3\n"
               "Parameters: 0.8 -0.6 0 0.6 0.8 0 0 0 1 4 5 6\nFixedParameters: 1 2 3\n");
    const auto one = jsonOf(vdbPack("pack " + folder.file("stem.stl") + " --transform " +
                                    folder.file("t.tfm") + common + folder.file("c.vtp")));
    const std::string recipe = folder.file("c.recipe.toml");
    CHECK_THAT(contentOf(recipe), Contains("t.tfm"));
    const auto again = jsonOf(vdbPack("pack --config " + recipe + " --quiet --json"));
    CHECK(again["hash"] == one["hash"]);
    CHECK(one["overlap"]["pairs"] == 0);
}

TEST_CASE("files that are no images in spite of their names are refused") {
    const TemporaryFolder folder;
    for (const char* name : {"ct.nii.gz", "label.seg.nrrd", "ct.mhd", "ct.dcm", "ct.tif"}) {
        const std::string file = folder.file(name);
        writeBytes(file, "x");
        for (const char* command : {"pack --json ", "image ", "mesh "}) {
            const Output refused = vdbPack(command + file);
            CAPTURE(command, file, refused.text);
            CHECK(refused.code == 3);
            CHECK_THAT(refused.text, Contains(name) && Contains("image"));
        }
    }
}

TEST_CASE("materials number regions and parts") {
    PackAttributes pack;
    CHECK_FALSE(Materials(pack).any());
    pack.region = {0, 1, 1};
    CHECK(Materials(pack).of(2) == 1);
    pack.columns = {{kPartColumn, {0, 0, 1}, {}}};
    CHECK(Materials(pack).of(1) == 1);
    CHECK(Materials(pack).of(2) == 3);
    CHECK(Materials(pack).withoutClass(1, 0) == 2);
    pack.region = {0, 0, 0};
    CHECK(Materials(pack).of(2) == 1);
    CHECK(Materials(pack).formula() == "part");
    pack.columns.push_back({"type", {1, 2, 3}, {}});
    CHECK_FALSE(Materials(pack).hasParts());
    pack.columns = {{kPartColumn, {}, {"neck", "neck", "head"}}};
    CHECK_FALSE(Materials(pack).hasParts());
    pack.region[1] = -1;
    CHECK_THROWS_AS(Materials(pack), ParameterError);
}

TEST_CASE("names in the file of a mesh, or its components, are packed and verified as parts") {
    const TemporaryFolder folder;
    // Of 1000 and 216 mm³ in a file in cm; the names come in turn.
    const TriangleMesh boxes[] = {boxMesh({{{0, 0, 0}}, {{1, 1, 1}}}),
                                  boxMesh({{{2, 0, 0}}, {{2.6, 0.6, 0.6}}})};
    std::string obj, stl, faces[4];
    for (int k = 0; k < 2; ++k) {
        const std::string name = k == 0 ? "bone" : "implant";
        for (const auto& v : boxes[k].vertices)
            obj += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
        stl += "solid " + name + "\n";
        for (std::size_t t = 0; t < boxes[k].triangles.size(); ++t) {
            const auto& c = boxes[k].triangles[t];
            const std::uint32_t first =
                1 + static_cast<std::uint32_t>(k * boxes[0].vertices.size());
            faces[t < 5 ? k : 2 + k] +=
                fmt::format("f {} {} {}\n", c[0] + first, c[1] + first, c[2] + first);
            stl += "facet normal 0 0 0\nouter loop\n";
            for (const auto v : c) {
                const Vec<3>& p = boxes[k].vertices[v];
                stl += fmt::format("vertex {} {} {}\n", p[0], p[1], p[2]);
            }
            stl += "endloop\nendfacet\n";
        }
        stl += "endsolid\n";
    }
    putContent(folder.file("m.stl"), stl);
    putContent(folder.file("m.obj"), obj + "o bone\n" + faces[0] + "g implant\n" + faces[1] +
                                         "g bone\n" + faces[2] + "g implant\n" + faces[3]);
    for (const auto& [file, by] : {std::pair{"m.stl", PartsBy::group},
                                   {"m.obj", PartsBy::group},
                                   {"m.obj", PartsBy::component}}) {
        CAPTURE(file, by == PartsBy::group);
        PackRecipe recipe = recipeFor(folder.file(file), "uniform:0.5,1");
        recipe.domain.unit = Unit::centimeter;
        recipe.domain.partsBy = by;
        const RunResult run = runPack(recipe);
        CHECK(run.passed);
        REQUIRE(run.report.parts.size() == 2);
        CHECK(run.report.parts[1].name == (by == PartsBy::group ? "implant" : "component 1"));
        CHECK(run.report.parts[0].volume == Approx(1000).epsilon(1e-6));
        CHECK(run.report.parts[1].volume == Approx(216).epsilon(1e-6));
        writePack(std::get<Pack<3>>(run.pack), folder.file("p.csv"));
        auto verify = onPack<VerifyRecipe>(folder.file("p.csv"));
        verify.domain = recipe.domain;
        CHECK(runVerify(verify).report.parts.size() == 2);
    }
    PackRecipe one = meshPart(folder.file("one.stl"), {{{0, 0, 0}}, {{9, 9, 9}}}, "");
    one.domain.partsBy = PartsBy::group;
    CHECK_THAT(messageOf<InputError>([&] { runPack(one); }), Contains("has 0 parts"));
}

TEST_CASE("a target count holds for all parts together, also where clips and parts cut them") {
    const TemporaryFolder folder;
    PackRecipe recipe;
    recipe.parts = {
        meshPart(folder.file("bone.stl"), {{{0, 0, 0}}, {{20, 20, 20}}}, "bone"),
        meshPart(folder.file("stem.stl"), {{{8, 8, 4}}, {{12, 12, 30}}}, "stem"),
        meshPart(folder.file("sheet.stl"), {{{30, 0, 0}}, {{31.5, 20, 20}}}, "sheet"),
    };
    recipe.parts[0].domain.clips = {parseClip("plane:0,0,1,10")};
    for (PackRecipe& part : recipe.parts) part.radius = {};
    recipe.targetCount = 3000;
    for (PackRecipe& part : recipe.parts) part.targetCount = 3000;
    recipe.outputs = {folder.file("surface.stl")};
    const RunResult run = runPack(recipe);
    CHECK(run.passed);
    CHECK(static_cast<double>(run.report.count) == Approx(3000).epsilon(0.02));
    CHECK(run.report.warnings.empty());
    // The stem takes 4 * 4 * 6 of 20 * 20 * 10.
    const std::string told = "bone: ";
    double share = 0;
    for (const std::string& text : run.report.chosen)
        if (text.find("of its volume left") != std::string::npos)
            share = std::stod(text.substr(told.size()));
    CHECK(share == Approx(2.4).epsilon(0.1));
    // A file holds the walls of all parts.
    CHECK(readMesh(folder.file("surface.stl")).bounds().hi[0] == Approx(31.5));

    // Radii of a part's own are no part of it.
    recipe.parts[2].radius = SizeRequest::parse("constant:0.7");
    const RunResult beside = runPack(recipe);
    const PartReport& sheet = beside.report.parts[2];
    CHECK(sheet.requested == "constant:0.7");
    CHECK(static_cast<double>(beside.report.count - sheet.count) == Approx(3000).epsilon(0.02));

    recipe.parts.resize(2);
    for (PackRecipe& part : recipe.parts) part.targetCount = 101;
    recipe.targetCount = 101;
    const RunResult few = runPack(recipe);
    const bool warned =
        std::any_of(few.report.warnings.begin(), few.report.warnings.end(),
                    [](const std::string& text) { return text.find("`targetCount` 101") == 0; });
    CHECK((warned || std::fabs(static_cast<double>(few.report.count) - 101) < 2.02));
}

TEST_CASE("a picture of parts shows what clips leave of them") {
    if (!canDrawSpace()) return;
    const TemporaryFolder folder;
    const auto pictured = [&](double height) {
        PackRecipe recipe;
        recipe.parts = {
            meshPart(folder.file("bone.stl"), {{{0, 0, 0}}, {{20, 20, height}}}, "bone"),
            meshPart(folder.file("stem.stl"), {{{8, 8, 4}}, {{12, 12, 15}}}, "stem"),
        };
        recipe.parts[0].domain.clips = {parseClip("plane:0,0,1,10")};
        recipe.preview.file = folder.file("p.png");
        recipe.preview.width = recipe.preview.height = 160;
        return static_cast<double>(runPack(recipe).picture.png.size());
    };
    // A bone of 300 mm in the frame would leave few pixels to the spheres.
    CHECK(pictured(300) == Approx(pictured(20)).epsilon(0.1));
}
