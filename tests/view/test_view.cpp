// Views are decoded as the page does it, and compared with their packs.
#include "support/test.h"
#include "support/well_formed.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/run/run.h"
#include "vdbpack/view/view_data.h"

#include <zlib.h>

#include <cstdlib>

namespace {

/// Spheres at random, with all columns; they may overlap.
template <int Dim>
Pack<Dim> randomPack(std::size_t count) {
    Pack<Dim> pack;
    RandomStream random(7, Dim);
    Column density{"density", {}, {}}, kind{"part", {}, {}}, word{"name", {}, {}};
    for (std::size_t i = 0; i < count; ++i) {
        Sphere<Dim> s;
        for (int d = 0; d < Dim; ++d) s.center[d] = 1000 + 40 * random.uniform();
        s.radius = 0.5 + random.uniform();
        pack.spheres.push_back(s);
        pack.id.push_back(static_cast<std::int64_t>(5 * i) - 100);
        pack.region.push_back(static_cast<std::int32_t>(i % 2));
        pack.order.push_back(static_cast<std::int64_t>(i));
        pack.depth.push_back(static_cast<float>(9 * random.uniform()));
        pack.contacts.push_back(static_cast<std::int32_t>(random.bits() % 12));
        density.numbers.push_back(1000 * random.uniform());
        kind.numbers.push_back(static_cast<double>(random.bits() % 3));
        word.texts.push_back(i % 3 == 0 ? "a <b>" : "c & 'd'");
    }
    pack.columns = {density, kind, word};
    return pack;
}

using Json = nlohmann::ordered_json;

std::string bytesOfBase64(const std::string& text) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned held = 0, bits = 0;
    for (const char c : text.substr(0, text.find('='))) {
        held = held << 6 | static_cast<unsigned>(letters.find(c));
        bits += 6;
        if (bits >= 8) bytes += static_cast<char>(held >> (bits -= 8) & 255);
    }
    return bytes;
}

/// The whole numbers of facts, as the script of a view decodes them.
std::vector<std::uint32_t> wholeNumbersOf(const Json& facts) {
    const std::string packed = bytesOfBase64(facts["data"].get<std::string>());
    const auto count = facts["count"].get<std::size_t>();
    std::string plain(4 * count + 1, '\0');
    auto size = static_cast<uLongf>(plain.size());
    REQUIRE(uncompress(reinterpret_cast<Bytef*>(plain.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()),
                       static_cast<uLong>(packed.size())) == Z_OK);
    REQUIRE((size == 2 * count || size == 4 * count));
    std::vector<std::uint32_t> numbers(count);
    const std::size_t width = size / count;
    for (std::size_t i = 0; i < size; ++i)
        numbers[i / width] |= std::uint32_t{static_cast<std::uint8_t>(plain[i])} << 8 * (i % width);
    return numbers;
}

std::vector<double> valuesOf(const Json& facts) {
    std::vector<double> values;
    for (const std::uint32_t n : wholeNumbersOf(facts))
        values.push_back(facts["lo"].get<double>() + facts["step"].get<double>() * n);
    return values;
}

/// x, y and z of points.
std::vector<Vec<3>> pointsOf(const Json& parts) {
    const auto x = valuesOf(parts[0]), y = valuesOf(parts[1]), z = valuesOf(parts[2]);
    std::vector<Vec<3>> points;
    for (std::size_t i = 0; i < x.size(); ++i) points.push_back({{x[i], y[i], z[i]}});
    return points;
}

template <int Dim>
ViewScene<Dim> sceneOf(const Pack<Dim>& pack) {
    ViewScene<Dim> scene;
    scene.pack = &pack;
    return scene;
}

}  // namespace

TEST_CASE("a view shows parts by their names") {
    Pack<3> pack = randomPack<3>(50);
    pack.columns[1].names = {"hip", "femur", "stem"};
    for (const Json& column : viewData(sceneOf(pack), {})["columns"])
        if (column["name"] == "part") {
            CHECK(column["names"] == Json{"hip", "femur", "stem"});
            CHECK(column["colors"].size() == 3);
        }
}

DIM_TEST_CASE("a view holds each sphere within half a step, and its columns") {
    const Pack<Dim> pack = randomPack<Dim>(3000);
    const Json facts = viewData(sceneOf(pack), {});
    const auto centers = pointsOf(facts["spheres"]);
    const auto radii = valuesOf(facts["spheres"][3]);
    REQUIRE(centers.size() == pack.spheres.size());
    for (std::size_t i = 0; i < centers.size(); ++i) {
        for (int d = 0; d < Dim; ++d)
            REQUIRE(centers[i][d] == Approx(pack.spheres[i].center[d]).margin(0.5 * 41 / 65534));
        REQUIRE(radii[i] == Approx(pack.spheres[i].radius).margin(0.5 * 1.0 / 65534));
    }
    CHECK_FALSE(facts.contains("rows"));
    std::map<std::string, Json> columns;
    for (const Json& column : facts["columns"])
        columns[column["name"].template get<std::string>()] = column;
    REQUIRE(columns.size() == 8);
    // Numbers of rows need no data.
    CHECK_FALSE(columns["order"].contains("data"));
    CHECK(columns["order"]["lo"] == 0);
    CHECK(columns["region"]["names"] == Json{"cortical", "trabecular"});
    CHECK(columns["part"]["names"][2] == "2");
    CHECK_FALSE(columns["density"].contains("colors"));
    CHECK(columns["depth"]["unit"] == "mm");
    std::map<std::string, std::vector<double>> values;
    for (const auto& [name, column] : columns)
        if (column.contains("data")) values[name] = valuesOf(column);
    for (std::size_t i = 0; i < centers.size(); ++i) {
        REQUIRE(values["id"][i] == static_cast<double>(pack.id[i]));
        REQUIRE(values["region"][i] == pack.region[i]);
        REQUIRE(values["contacts"][i] == pack.contacts[i]);
        REQUIRE(values["part"][i] == pack.columns[1].numbers[i]);
        REQUIRE(values["depth"][i] == Approx(pack.depth[i]).margin(1e-4));
        REQUIRE(values["density"][i] == Approx(pack.columns[0].numbers[i]).margin(0.01));
        REQUIRE(columns["name"]["names"][static_cast<std::size_t>(values["name"][i])] ==
                pack.columns[2].texts[i]);
    }
}

TEST_CASE("whole numbers of a view are exact, others within half a step, and some are none") {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> whole{-5, 70000, 4294967290, 0};
    CHECK(valuesOf(packedNumbers(whole)) == whole);
    const Json some = packedNumbers({1.5, nothing, -3.25, 7, 1e-3});
    const auto numbers = wholeNumbersOf(some);
    CHECK(numbers[1] == 65535);
    CHECK(numbers[2] == 0);
    CHECK(numbers[3] == 65534);
    CHECK(valuesOf(some)[4] == Approx(1e-3).margin(some["step"].get<double>() / 2));
    CHECK(valuesOf(packedNumbers({2.5, 2.5})) == std::vector<double>{2.5, 2.5});
    CHECK(wholeNumbersOf(packedNumbers({nothing}))[0] == 65535);
    const double infinite = std::numeric_limits<double>::infinity();
    CHECK(wholeNumbersOf(packedNumbers({1, infinite}))[1] == 65535);
}

TEST_CASE("of a large pack a random subset is shown, alike everywhere, and the page says so") {
    Pack<3> pack;
    for (int i = 0; i < 40 * 40 * 40; ++i) {
        pack.spheres.push_back({{{2.0 * (i % 40), 2.0 * (i / 40 % 40), 2.0 * (i / 1600)}}, 1});
        pack.order.push_back(i + 7);
        pack.contacts.push_back(i % 11);
    }
    ViewOptions options;
    options.mostSpheres = 16000;
    const Json facts = viewData(sceneOf(pack), options);
    CHECK_THAT(facts["words"].get<std::string>(), Contains("16,000 of 64,000"));
    const auto steps = valuesOf(facts["rows"]), contacts = valuesOf(facts["columns"][1]);
    const auto centers = pointsOf(facts["spheres"]);
    REQUIRE(steps.size() == options.mostSpheres);
    CHECK(facts["columns"][0]["lo"] == 7);
    std::array<int, 8> inOctant{};
    std::size_t row = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        row += static_cast<std::size_t>(steps[i]);
        REQUIRE(length(centers[i] - pack.spheres[row].center) < 0.01);
        REQUIRE(contacts[i] == pack.contacts[row]);
        ++inOctant[(centers[i][0] > 39) + 2 * (centers[i][1] > 39) + 4 * (centers[i][2] > 39)];
    }
    // 2000 of 8000 each; their standard deviation is 36.
    for (const int n : inOctant) CHECK(std::abs(n - 2000) < 180);
    CHECK(viewData(sceneOf(pack), options) == facts);
    CHECK_THAT(viewData(sceneOf(pack), {})["words"].get<std::string>(), !Contains("64,000"));
}

TEST_CASE("columns and walls that would make a page too large are left out, and it says so") {
    const Pack<3> pack = randomPack<3>(4000);
    ViewOptions options;
    options.mostBytes = 75000;
    const TriangleMesh wall = boxMesh({{{999, 999, 999}}, {{1041, 1041, 1041}}});
    ViewScene<3> scene = sceneOf(pack);
    scene.wall = &wall;
    Json facts = viewData(scene, options);
    CHECK(facts["spheres"].dump().size() + facts["columns"].dump().size() <=
          options.mostBytes + 20);
    CHECK(facts["columns"].size() < 8);
    CHECK_THAT(facts["words"].get<std::string>(), Contains("density"));
    const auto corners = wholeNumbersOf(facts["wall"]["corners"]);
    REQUIRE(corners.size() == 36);
    const auto points = pointsOf(facts["wall"]["points"]);
    for (std::size_t i = 0; i < corners.size(); ++i)
        REQUIRE(points[corners[i]] == wall.vertices[wall.triangles[i / 3][i % 3]]);
    options.mostTriangles = 11;
    facts = viewData(scene, options);
    CHECK_FALSE(facts.contains("wall"));
    CHECK_THAT(facts["words"].get<std::string>(), Contains("12 triangles"));
}

TEST_CASE("the outline of a disc is a circle of its length") {
    const Pack<2> pack = randomPack<2>(1);
    PlaneField field;
    field.columns = field.rows = 200;
    field.step = 0.15;
    field.origin = {{-4, 85}};
    const Vec<3> center{{10.3, 99.8, 0}};
    for (std::int64_t j = 0; j < field.rows; ++j)
        for (std::int64_t i = 0; i < field.columns; ++i)
            field.distance.push_back(static_cast<float>(
                std::hypot(field.origin[0] + static_cast<double>(i) * field.step - center[0],
                           field.origin[1] + static_cast<double>(j) * field.step - center[1]) -
                9));
    ViewScene<2> scene = sceneOf(pack);
    scene.field = &field;
    const auto ends = pointsOf(viewData(scene, {})["wall"]["points"]);
    REQUIRE(ends.size() % 2 == 0);
    double total = 0;
    for (std::size_t k = 0; k < ends.size(); k += 2) {
        REQUIRE(length(ends[k] - center) == Approx(9).margin(0.003));
        total += length(ends[k] - ends[k + 1]);
    }
    CHECK(total == Approx(2 * kPi * 9).epsilon(1e-3));
}

TEST_CASE("a page with a view is well-formed and names nothing to fetch") {
    const Pack<3> pack = randomPack<3>(400);
    const TriangleMesh wall = boxMesh({{{999, 999, 999}}, {{1041, 1041, 1041}}});
    ViewScene<3> scene = sceneOf(pack);
    scene.wall = &wall;
    const ViewMarkup view = viewOf(scene);
    PagePicture picture;
    picture.png = "picture";
    picture.view = view.body;
    picture.viewStyle = view.style;
    const std::string page = htmlPage("a", picture.viewStyle, pictureFigure(picture));
    CHECK(flawIn(page) == "");
    for (const char* word : {"http", "url(", "@import", "import(", "fetch("}) {
        CAPTURE(word);
        CHECK(page.find(word) == std::string::npos);
    }
    CHECK_THAT(page, Contains("<img src='data:image/png") && Contains("\"a \\u003cb\\u003e\""));
    CHECK_THROWS_AS(viewOf(sceneOf(Pack<3>{})), ParameterError);
}

TEST_CASE("view writes a page of a pack of any dimension") {
    const TemporaryFolder folder;
    const bool plane = GENERATE(false, true);
    CAPTURE(plane);
    ViewRecipe recipe;
    recipe.pack = folder.file("a pack.csv");
    recipe.reportFile = folder.file("page.html");
    if (plane)
        writePack(randomPack<2>(50), recipe.pack);
    else
        writePack(randomPack<3>(50), recipe.pack);
    recipe.domain.source = plane ? "rect:990,990,1050,1050" : "box:990,990,990,1050,1050,1050";
    const ViewResult result = runView(recipe);
    CHECK(result.kind == (plane ? "circles" : "spheres"));
    CHECK(result.count == 50);
    CHECK(result.file == recipe.reportFile);
    const std::string page = contentOf(recipe.reportFile);
    CHECK(result.bytes == page.size());
    CHECK(flawIn(page) == "");
    CHECK_THAT(page, Contains("a pack.csv: 50 ") && Contains("view-facts"));
    recipe.domain.source = plane ? "box:9,9,9" : "rect:9,9";
    CHECK_THROWS_AS(runView(recipe), ParameterError);
    recipe.domain.source.clear();
    recipe.reportFile = folder.file("page.txt");
    CHECK_THROWS_AS(runView(recipe), ParameterError);
    recipe.reportFile = recipe.pack;
    CHECK_THROWS_AS(runView(recipe), ParameterError);
    recipe.pack = folder.file("absent.csv");
    recipe.reportFile = folder.file("page.html");
    CHECK_THROWS(runView(recipe));
}

TEST_CASE("a view tells of a domain that cannot be the pack's") {
    const TemporaryFolder folder;
    ViewRecipe recipe;
    recipe.pack = folder.file("pack.csv");
    recipe.reportFile = folder.file("view.html");
    writePack(randomPack<3>(20), recipe.pack, {});
    recipe.domain.gridName = "solid";
    CHECK_THROWS_AS(runView(recipe), ParameterError);
    recipe.domain.gridName.clear();
    CHECK(runView(recipe).warnings.empty());
    recipe.domain.source = "box:0,0,0,10,10,10";
    CHECK_FALSE(runView(recipe).warnings.empty());
    recipe.domain.source.clear();
    recipe.pack = folder.file("absent.stl");
    CHECK_THROWS_AS(runView(recipe), IoError);
    recipe.pack = folder.file(".");
    CHECK_THROWS_AS(runView(recipe), Error);
}

TEST_CASE("view shows a solid by its triangles, and several in a color each") {
    const TriangleMesh box = boxMesh({{{-1, -2, -3}}, {{1, 2, 3}}});
    ViewScene<3> scene;
    scene.wall = &box;
    scene.solids = {{"a", 4}, {"b", 8}};
    const Json facts = viewData(scene, ViewOptions{});
    CHECK(facts["half"] == Json({1, 2, 3}));
    CHECK(facts["spheres"][0]["count"] == 0);
    REQUIRE(facts["solids"].size() == 2);
    CHECK(facts["solids"][1]["name"] == "b");
    CHECK(facts["solids"][1]["corners"] == 24);
    CHECK(facts["solids"][0]["color"] != facts["solids"][1]["color"]);
    CHECK_THAT(viewOf(scene).body, Contains("of-solids"));

    const TemporaryFolder folder;
    ViewRecipe recipe;
    recipe.pack = "box:2,4,6";
    recipe.reportFile = folder.file("page.html");
    const ViewResult result = runView(recipe);
    CHECK(result.kind == "triangles");
    CHECK(result.count == 12);
    const std::string page = contentOf(recipe.reportFile);
    CHECK(flawIn(page) == "");
    CHECK_THAT(page, Contains("12 triangles") && Contains("2 x 4 x 6 mm"));
    recipe.pack = "rect:2,4";
    CHECK_THROWS_WITH(runView(recipe), Contains("is plane"));
    recipe.pack = "box:2,4,6";
    recipe.domain.source = "ball:1";
    CHECK_THROWS_WITH(runView(recipe), Contains("is a solid"));
}
