// USD: what is written; it is not read back.
#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstring>

namespace {

/// The numbers between the brackets after a name.
std::vector<double> numbersOf(const std::string& text, const std::string& name) {
    std::vector<double> numbers;
    const auto begin = text.find(name + " = [");
    REQUIRE(begin != std::string::npos);
    const auto end = text.find(']', begin + name.size() + 4);
    for (auto at = begin + name.size() + 4; at < end;) {
        char* after = nullptr;
        const double value = std::strtod(text.c_str() + at, &after);
        if (after != text.c_str() + at) numbers.push_back(value);
        at = std::max(at + 1, static_cast<std::size_t>(after - text.c_str()));
    }
    return numbers;
}

}  // namespace

TEST_CASE("a .usda file begins as its schemas ask") {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}, {{{2, 0, 0.5}}, 1.25}};
    pack.region = {0, 1};
    REQUIRE(writtenText(pack, "p.usda") == R"(#usda 1.0
(
    customLayerData = {
        string unit_of_length = "mm"
    }
    defaultPrim = "pack"
    metersPerUnit = 0.001
    upAxis = "Z"
)

def Xform "pack" (
    kind = "component"
)
{

    def Points "spheres"
    {
        float3[] extent = [(-1, -1.25, -1), (3.25, 1.25, 1.75)]
        int64[] ids = [
0,
1]
        point3f[] points = [
(0, 0, 0),
(2, 0, 0.5)]
        float[] widths = [
2,
2.5] (
            interpolation = "vertex"
        )
        color3f[] primvars:displayColor = [(0.87, 0.82, 0.72)]
        int[] primvars:region = [
0,
1] (
            interpolation = "vertex"
        )
    }
}
)");
}

TEST_CASE("every column of a .usda has one value a sphere, under a name that USD accepts") {
    auto pack = packWithColumns(GENERATE(0u, 1u, 500u), "a b", "größe", {"", "say \"\\\"\n\xff"});
    const std::size_t n = pack.spheres.size();
    for (const char* name : {"a_b", "7", "displayColor"})
        pack.columns.push_back({name, std::vector<double>(n, 0.1), {}});
    const auto text = writtenText(pack, "p.usda");
    REQUIRE(std::count(text.begin(), text.end(), '{') == std::count(text.begin(), text.end(), '}'));
    REQUIRE(numbersOf(text, "point3f[] points").size() == 3 * n);
    REQUIRE(numbersOf(text, "float[] widths").size() == n);
    REQUIRE(numbersOf(text, "int64[] ids") == std::vector<double>(pack.id.begin(), pack.id.end()));
    if (n == 0) return;
    REQUIRE(numbersOf(text, "int[] primvars:region").size() == n);
    REQUIRE(numbersOf(text, "double[] primvars:a_b") == pack.columns[0].numbers);
    for (const char* name : {"a_b_2", "_7", "displayColor_2"})
        REQUIRE(numbersOf(text, std::string("double[] primvars:") + name).size() == n);
    REQUIRE_THAT(text, Contains("displayName = \"a b\"") && Contains("displayName = \"größe\""));
    if (n > 1) REQUIRE_THAT(text, Contains("\"say \\\"\\\\\\\"\\x0a\\xff\""));
}

TEST_CASE("points of a .usda are floats about an origin near them") {
    Pack<3> pack = latticePack<3>(200, {{730, -650, 4}}, 30, 8);
    const auto text = writtenText(pack, "p.usda");
    REQUIRE_THAT(text, Contains("uniform token[] xformOpOrder = [\"xformOp:translate\"]"));
    const auto points = numbersOf(text, "point3f[] points");
    const auto widths = numbersOf(text, "float[] widths");
    const auto extent = numbersOf(text, "float3[] extent");
    REQUIRE(points.size() == 600);
    REQUIRE(extent.size() == 6);
    std::array<double, 6> tight = {1e9, 1e9, 1e9, -1e9, -1e9, -1e9};
    for (std::size_t i = 0; i < 600; ++i) {
        REQUIRE(std::abs(points[i]) < 40);
        const std::size_t d = i % 3;
        tight[d] = std::min(tight[d], points[i] - widths[i / 3] / 2);
        tight[d + 3] = std::max(tight[d + 3], points[i] + widths[i / 3] / 2);
    }
    for (std::size_t k = 0; k < 6; ++k) {
        CAPTURE(k);
        const bool upper = k > 2;
        CHECK((upper ? extent[k] >= tight[k] : extent[k] <= tight[k]));
        CHECK(std::abs(extent[k] - tight[k]) < 1e-5);
        CHECK(static_cast<double>(static_cast<float>(extent[k])) ==
              Approx(extent[k]).epsilon(1e-9));
    }
}

TEST_CASE("a .usda file records its unit, its generator and the periodic cell") {
    Pack<3> pack;
    pack.spheres = {{{{1, 2, 3}}, 0.5}};
    pack.cell.wraps = {true, false, true};
    pack.cell.box.lo = {{0, 0, 0}};
    pack.cell.box.hi = {{8, 8, 8}};
    PackWriteOptions options;
    options.generator = "a \"b\" 1";
    options.unit = GENERATE(Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer);
    const auto text = writtenText(pack, "p.usda", options);
    REQUIRE_THAT(text, Contains("string generator = \"a \\\"b\\\" 1\""));
    if (options.unit == Unit::micrometer) REQUIRE_THAT(text, Contains("metersPerUnit = 1e-06"));
    REQUIRE_THAT(text, Contains("string periodic_cell = \"xz 0.0 0.0 0.0 "));
}

TEST_CASE("circles of a slice become points at its height") {
    Pack<2> pack = latticePack<2>(20, {{0, 0}}, 10, 3);
    pack.sliceHeight = 12.5;
    const auto points = numbersOf(writtenText(pack, "p.usda"), "point3f[] points");
    for (std::size_t i = 0; i < 20; ++i) {
        REQUIRE(points[3 * i] == pack.spheres[i].center[0]);
        REQUIRE(points[3 * i + 2] == points[2]);
    }
}

TEST_CASE("a surface stands beside the points, in the same place") {
    Pack<3> pack;
    pack.spheres = {{{{101, 0.2, 0.2}}, 0.1}, {{{101.5, -0.2, 0.2}}, 0.1}};
    TriangleMesh mesh;
    mesh.vertices = {{{100, 0, 0}}, {{104, 0, 0}}, {{100, 3, 0}}, {{100, 0, 2}}};
    mesh.triangles = {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{0, 3, 2}}};
    PackWriteOptions options;
    options.surface = &mesh;
    options.surfaceName = "the wall";
    options.unit = Unit::centimeter;
    const auto text = writtenText(pack, "p.usda", options);
    const auto from = text.find("def Mesh \"the_wall\"");
    REQUIRE(from != std::string::npos);
    const auto surface = text.substr(from);
    REQUIRE(numbersOf(surface, "int[] faceVertexCounts") == std::vector<double>(4, 3.0));
    REQUIRE(numbersOf(surface, "int[] faceVertexIndices") ==
            std::vector<double>{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2});
    const auto vertices = numbersOf(surface, "point3f[] points");
    const auto points = numbersOf(text, "point3f[] points");
    // Of vertex 0 and sphere 0, in cm: the translation is that of both.
    REQUIRE(points[0] - vertices[0] == Approx(0.1).margin(1e-6));
    REQUIRE(vertices[1] == 0);
}

TEST_CASE("a .usdz begins its file at a multiple of 64 bytes, uncompressed") {
    const auto pack = packWithColumns(7, "n", "t", {"a", "b"});
    const auto bytes = writtenText(pack, "p.usdz"), text = writtenText(pack, "p.usda");
    REQUIRE(bytes.find(text) % 64 == 0);
    REQUIRE(bytes.substr(0, 4) == "PK\3\4");
    const auto read16 = [&](std::size_t at) {
        return static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1])
                                                           << 8;
    };
    REQUIRE(read16(8) == 0);  // stored
    REQUIRE(30 + read16(26) + read16(28) == static_cast<int>(bytes.find(text)));
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 22, 4);
    REQUIRE(size == text.size());
}

TEST_CASE("reading USD is refused with what to do instead") {
    const std::string file = GENERATE("p.usda", "p.usd", "p.usdz");
    REQUIRE_THROWS_AS(readPack(file), ParameterError);
    REQUIRE_THROWS_WITH(readPack(file), Contains(file) && Contains("not read") &&
                                            Contains(".vtp") && Contains(".csv") &&
                                            Contains("the program"));
}
