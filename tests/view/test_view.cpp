// Views are decoded as the page does it, and compared with their packs.
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "support/well_formed.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/run/run_view.h"
#include "vdbpack/view/view_data.h"

#include <catch2/catch.hpp>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;

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

/// The arrays of a view by name, as its script decodes them.
std::map<std::string, std::vector<std::uint64_t>> arraysIn(const ViewData& data) {
    std::map<std::string, std::vector<std::uint64_t>> arrays;
    std::size_t at = 0;
    for (const auto& array : data.facts["arrays"]) {
        const auto count = array["count"].get<std::size_t>();
        const auto planes = array["planes"].get<std::size_t>();
        const auto bytes = array["bytes"].get<std::size_t>();
        std::string plain(count * planes, '\0');
        auto size = static_cast<uLongf>(plain.size());
        REQUIRE(uncompress(reinterpret_cast<Bytef*>(plain.data()), &size,
                           reinterpret_cast<const Bytef*>(data.bytes.data() + at),
                           static_cast<uLong>(bytes)) == Z_OK);
        REQUIRE(size == plain.size());
        at += bytes;
        auto& numbers = arrays[array["name"].get<std::string>()];
        for (std::size_t i = 0; i < count; ++i) {
            std::uint64_t n = 0;
            for (std::size_t p = planes; p-- > 0;)
                n = n << 8 | static_cast<std::uint8_t>(plain[p * count + i]);
            numbers.push_back(n);
        }
    }
    REQUIRE(at == data.bytes.size());
    return arrays;
}

Vec<3> placeOf(std::uint64_t code) {
    Vec<3> place;
    for (int bit = 0; bit < 16; ++bit)
        for (int d = 0; d < 3; ++d)
            place[d] += static_cast<double>(code >> (3 * bit + d) & 1) * (1 << bit);
    return place;
}

template <int Dim>
ViewScene<Dim> sceneOf(const Pack<Dim>& pack) {
    ViewScene<Dim> scene;
    scene.pack = &pack;
    return scene;
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("a view holds each sphere within half a step, and its columns", "[view]",
                       ((int Dim), Dim), 2, 3) {
    const Pack<Dim> pack = randomPack<Dim>(3000);
    const ViewData data = viewData(sceneOf(pack), {});
    auto arrays = arraysIn(data);
    const auto& facts = data.facts;
    const auto& rows = arrays["row"];
    REQUIRE(rows.size() == pack.spheres.size());
    auto sorted = rows;
    std::sort(sorted.begin(), sorted.end());
    const auto outer = facts["outer"].get<std::size_t>(), inner = facts["inner"].get<std::size_t>();
    const double step = facts["step"], radiusStep = facts["radius"]["step"];
    std::uint64_t code = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        REQUIRE(sorted[i] == i);
        code = (i == outer || i == outer + inner ? 0 : code) + arrays["code"][i];
        const Sphere<Dim>& s = pack.spheres[rows[i]];
        const Vec<3> place = placeOf(code);
        for (int d = 0; d < Dim; ++d)
            REQUIRE(facts["lo"][static_cast<std::size_t>(d)].template get<double>() +
                        step * place[d] ==
                    Approx(s.center[d]).margin(0.501 * step));
        REQUIRE(facts["radius"]["lo"].template get<double>() +
                    radiusStep * static_cast<double>(arrays["radius"][i]) ==
                Approx(s.radius).margin(0.501 * radiusStep));
    }
    std::map<std::string, nlohmann::ordered_json> columns;
    for (const auto& column : facts["columns"])
        columns[column["name"].template get<std::string>()] = column;
    CHECK(columns.size() == 8);
    CHECK(columns["order"]["isRow"] == true);
    CHECK(columns["part"]["kinds"] == true);
    CHECK_FALSE(columns["density"].contains("whole"));
    const auto valueOf = [&](const std::string& name, std::size_t i) {
        return columns[name]["lo"].template get<double>() +
               columns[name]["step"].template get<double>() *
                   static_cast<double>(arrays[":" + name][i]);
    };
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::size_t row = rows[i];
        REQUIRE(valueOf("id", i) == static_cast<double>(pack.id[row]));
        REQUIRE(valueOf("region", i) == pack.region[row]);
        REQUIRE(valueOf("contacts", i) == pack.contacts[row]);
        REQUIRE(valueOf("part", i) == pack.columns[1].numbers[row]);
        REQUIRE(valueOf("depth", i) == Approx(pack.depth[row]).margin(1e-4));
        REQUIRE(valueOf("density", i) == Approx(pack.columns[0].numbers[row]).margin(0.01));
        REQUIRE(columns["name"]["words"][arrays[":name"][i]] == pack.columns[2].texts[row]);
    }
}

TEST_CASE("a view is the same for any number of threads", "[view]") {
    const Pack<3> pack = randomPack<3>(5000);
    const TriangleMesh wall = boxMesh({{{999, 999, 999}}, {{1041, 1041, 1041}}});
    const auto madeBy = [&](int threads) {
        return withThreads(threads, [&] {
            ViewScene<3> scene = sceneOf(pack);
            scene.wall = &wall;
            return viewOf(scene).body;
        });
    };
    const std::string one = madeBy(1);
    for (const int threads : {2, 3, 8}) {
        CAPTURE(threads);
        CHECK(madeBy(threads) == one);
    }
}

TEST_CASE("of a large pack the surface and the planes of a cut are shown, and the page says so",
          "[view]") {
    Pack<3> pack;
    for (int i = 0; i < 40 * 40 * 40; ++i)
        pack.spheres.push_back({{{2.0 * (i % 40), 2.0 * (i / 40 % 40), 2.0 * (i / 1600)}}, 1});
    ViewOptions options;
    options.mostSpheres = 50000;
    options.cut = PreviewCut{0, 39};
    const ViewData data = viewData(sceneOf(pack), options);
    auto arrays = arraysIn(data);
    REQUIRE(arrays["row"].size() == options.mostSpheres);
    CHECK(data.facts["of"] == pack.spheres.size());
    CHECK_THAT(data.facts["words"].get<std::string>(),
               Catch::Contains("50,000 of 64,000") && Catch::Contains("x = 39"));
    std::vector<bool> shown(pack.spheres.size());
    for (const auto row : arrays["row"]) shown[row] = true;
    std::size_t others = 0, kept = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Vec<3>& x = pack.spheres[i].center;
        double depth = 40;
        for (int d = 0; d < 3; ++d) depth = std::min({depth, x[d] + 1, 79 - x[d]});
        if (depth < 4 || (x[0] > 34 && x[0] < 40)) REQUIRE(shown[i]);
        if (depth > 12 && (x[0] < 30 || x[0] > 41)) {
            ++others;
            kept += shown[i];
        }
    }
    CHECK(kept > others / 20);
    CHECK(kept < others);
    // Without a limit, all.
    CHECK(viewData(sceneOf(pack), {}).facts.contains("words") == false);
}

TEST_CASE("columns that would make a page too large are left out, and it says so", "[view]") {
    const Pack<3> pack = randomPack<3>(4000);
    ViewOptions options;
    options.mostBytes = 55000;
    const ViewData data = viewData(sceneOf(pack), options);
    CHECK(data.bytes.size() <= options.mostBytes);
    CHECK(data.facts["columns"].size() < 8);
    CHECK_THAT(data.facts["leftOut"].get<std::string>(), Catch::Contains("density"));
    Pack<3> named = randomPack<3>(500);
    named.columns = {Column{"label", {}, {}}};
    for (int i = 0; i < 500; ++i) named.columns[0].texts.push_back(std::to_string(i));
    CHECK(viewData(sceneOf(named), {}).facts["leftOut"] == "label");
}

TEST_CASE("a page with a view is well-formed and names nothing to fetch", "[view]") {
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
    CHECK_THAT(page, Catch::Contains("<img src='data:image/png") &&
                         Catch::Contains("\"a \\u003cb\\u003e\""));
    CHECK_THROWS_AS(viewOf(sceneOf(Pack<3>{})), ParameterError);
}

TEST_CASE("view writes a page of a pack of any dimension", "[view][run]") {
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
    CHECK_THAT(page, Catch::Contains("a pack.csv: 50 ") && Catch::Contains("view-bytes"));
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

TEST_CASE("a view tells of a domain that cannot be the pack's", "[view]") {
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
    recipe.pack = folder.file("mesh.stl");
    CHECK_THROWS_AS(runView(recipe), InputError);
    recipe.pack = folder.file(".");
    CHECK_THROWS_AS(runView(recipe), IoError);
}
