// USD: what we write, what other programs do, and what is broken.
#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/flipped_bits.h"

#include "vdbpack/mesh/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

/// A stage in mm with one Points prim of these statements.
std::string stageOf(const std::string& statements, const std::string& around = {}) {
    return "#usda 1.0\n(\n    metersPerUnit = 0.001\n)\ndef Xform \"a\"\n{\n" + around +
           "    def Points \"p\"\n    {\n" + statements + "    }\n}\n";
}

const char* const kTwo =
    "point3f[] points = [(1, 2, 3), (4, 5, 6)]\n"
    "float[] widths = [1, 2] (interpolation = \"vertex\")\n";

std::vector<Sphere<3>> placed(const std::string& around) {
    return readText("p.usda", stageOf(kTwo, around)).spheres;
}

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

TEST_CASE("a .usda file begins as its schemas ask", "[formats][usd]") {
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

TEST_CASE("a .usda file gives back the same pack", "[formats][usd]") {
    const auto pack = packWithColumns(GENERATE(0u, 1u, 500u), "Young's modulus", "größe",
                                      {"", "say \"\\\"\n\ta\xff\xf0\x9f\xa6\xb4\x01"});
    const std::string file = GENERATE("p.usda", "p.usd", "p.usdz");
    const auto read = readText(file, writtenText(pack, file));
    REQUIRE(read.spheres == pack.spheres);
    requireSameAttributes(read, pack);
    if (pack.spheres.empty()) return;
    REQUIRE(read.columns.size() == 2);
    for (std::size_t c = 0; c < 2; ++c) {
        REQUIRE(read.columns[c].name == pack.columns[c].name);
        REQUIRE(read.columns[c].numbers == pack.columns[c].numbers);
        REQUIRE(read.columns[c].texts == pack.columns[c].texts);
    }
}

TEST_CASE("names of columns that USD cannot have come back", "[formats][usd]") {
    Pack<3> pack;
    pack.spheres = {{{{1, 2, 3}}, 1}};
    for (const char* name : {"a b", "a_b", "a:b", "7", "displayColor", "radius_1", "velocities"})
        pack.columns.push_back({name, {0.1}, {}});
    const auto text = writtenText(pack, "p.usda");
    REQUIRE_THAT(text, Contains("primvars:_7 = ") && Contains("primvars:a_b_2 = "));
    const auto read = readText("p.usda", text);
    REQUIRE(read.columns.size() == pack.columns.size());
    for (std::size_t c = 0; c < pack.columns.size(); ++c) {
        CHECK(read.columns[c].name == pack.columns[c].name);
        CHECK(read.columns[c].numbers == pack.columns[c].numbers);
    }
}

TEST_CASE("any doubles survive a .usda file, wherever the spheres lie", "[formats][usd]") {
    RandomStream random(GENERATE(range(1u, 9u)), 3);
    Pack<3> pack;
    Vec<3> center, size;
    for (int d = 0; d < 3; ++d) {
        center[d] = 2000 * (random.uniform() - 0.5);
        size[d] = std::exp2(20 * random.uniform() - 10);
    }
    for (int i = 0; i < 300; ++i) {
        Sphere<3> s;
        for (int d = 0; d < 3; ++d) s.center[d] = center[d] + size[d] * (random.uniform() - 0.5);
        s.radius = 1e-3 + random.uniform() / 3;
        pack.spheres.push_back(s);
    }
    pack.columns.push_back({"odd", std::vector<double>(300, 1.0 / 3), {}});
    pack.columns.back().numbers[1] = std::numeric_limits<double>::infinity();
    pack.columns.back().numbers[2] = -5e-324;
    const auto read = readText("p.usda", writtenText(pack, "p.usda"));
    REQUIRE(read.spheres == pack.spheres);
    REQUIRE(read.columns[0].numbers == pack.columns[0].numbers);
}

TEST_CASE("points of a .usda are floats about an origin near them", "[formats][usd]") {
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

TEST_CASE("a .usda file records its unit, its generator and the periodic cell", "[formats][usd]") {
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
    const auto read = readText("p.usda", text);
    REQUIRE(read.spheres == pack.spheres);
    REQUIRE(read.cell.wraps == pack.cell.wraps);
    REQUIRE(read.cell.box.hi == pack.cell.box.hi);
}

TEST_CASE("circles of a slice become points at its height", "[formats][usd]") {
    Pack<2> pack = latticePack<2>(20, {{0, 0}}, 10, 3);
    pack.sliceHeight = 12.5;
    const auto read = asCircles(readText("p.usda", writtenText(pack, "p.usda")));
    REQUIRE(read.spheres == pack.spheres);
    REQUIRE(read.sliceHeight == 12.5);
}

TEST_CASE("a surface stands beside the points, in the same place", "[formats][usd]") {
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
    REQUIRE(readText("p.usda", text).spheres.size() == 2);
}

TEST_CASE("a .usda of another program is read", "[formats][usd]") {
    // As Houdini and usdcat write: types and comments of all kinds, variants, values by time.
    const auto read = readText("p.usda", R"(#usda 1.0
(
    "comment"
    doc = """two
lines with "quotes" """
    endTimeCode = 2
    metersPerUnit = 0.01
    subLayers = [ @./a.usda@ (offset = 1), @@@b @.usda@@@ ]
    customLayerData = { string "a key" = "x"; dictionary d = { int[] n = [1, 2] } }
)
/* nothing */
def Scope "Looks" { def Material "m" { token outputs:surface.connect = </Looks/m/s.outputs:surface> } }
class "_c" { def Points "none" { point3f[] points = [(9, 9, 9)] } }
over "geo" { def Points "empty" { } }
def Xform "geo" (
    prepend references = @x.usd@</geo>
    variants = { string size = "big" }
    prepend variantSets = "size"
)
{
    reorder properties = ["b", "a"]
    custom rel target
    float unset
    asset file = @a.png@ ( doc = "a" )
    variantSet "size" = { "big" { def Points "q" { point3f[] points = [(0, 0, 0)] } } }
    def Points "first" ( active = true )
    {
        float3[] extent.timeSamples = { 1: [(0, 0, 0), (1, 1, 1)] }
        point3f[] points = [(7, 7, 7)]
        point3f[] points.timeSamples = {
            2: [(1, 2, 3), (4, 5, 6),],  # the last one
            1: [(0, 0, 0)],
            0: None,
        }
        float[] widths = [0.5] ( interpolation = "constant" )
        uniform token subsetFamily:type = "a"
        vector3f[] velocities = [(1, 0, 0), (0, 2, 0)];int64[] ids = [5, 9]
        string[] primvars:part = ["a", 'b'] (
            customData = { bool x = 1 }
            interpolation = "varying"
        )
        int[] primvars:part:indices = [1, 0]
        bool[] primvars:on = [true, 0] ( interpolation = "vertex" )
        float[] primvars:pscale = [3, 4] ( interpolation = "vertex" )
        half[] primvars:h = [inf, -.5e1] ( interpolation = "vertex" )
        color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] ( interpolation = "vertex" )
        float primvars:all = 3 ( interpolation = "constant" )
        matrix4d[] xforms = [ ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) ) ]
    }
    def Points "second" { point3f[] points = [(1, 1, 1)] }
}
)");
    REQUIRE(read.spheres == std::vector<Sphere<3>>{{{{10, 20, 30}}, 2.5}, {{{40, 50, 60}}, 2.5}});
    REQUIRE(read.id == std::vector<std::int64_t>{5, 9});
    std::vector<std::string> names;
    for (const auto& column : read.columns) names.push_back(column.name);
    REQUIRE(names == std::vector<std::string>{"velocities_0", "velocities_1", "velocities_2",
                                              "part", "on", "pscale", "h", "displayColor_0",
                                              "displayColor_1", "displayColor_2"});
    REQUIRE(read.columns[1].numbers == std::vector<double>{0, 2});
    REQUIRE(read.columns[3].texts == std::vector<std::string>{"b", "a"});
    REQUIRE(read.columns[4].numbers == std::vector<double>{1, 0});
    REQUIRE(read.columns[6].numbers[1] == -5);
}

TEST_CASE("the Points prim of a .usda can be chosen", "[formats][usd]") {
    const TemporaryFolder scratch;
    const auto file = scratch.file("p.usda");
    putContent(file, "#usda 1.0\ndef Points \"a\" {\n" + std::string(kTwo) +
                         "}\ndef \"g\" { def Points \"b\" { point3f[] points = [(7, 8, 9)]\n"
                         "float[] widths = [2] } }\n");
    PackReadOptions options;
    const auto first = [&] { return readPack(file, options).spheres[0].center[0]; };
    REQUIRE(first() == 1);
    options.gridName = GENERATE("b", "/g/b", "g/b");
    REQUIRE(first() == 7);
    options.gridName = "c";
    REQUIRE_THAT(messageOf<InputError>(first), Contains("'c'") && Contains("/g/b"));
}

TEST_CASE("transformations of a .usda move, turn and scale spheres", "[formats][usd]") {
    const auto op = [](const std::string& type, const std::string& name, const std::string& value) {
        return type + " xformOp:" + name + " = " + value + "\n";
    };
    const auto order = [](const std::string& names) {
        return "uniform token[] xformOpOrder = [" + names + "]\n";
    };
    const auto center = [](const std::string& around) { return placed(around)[0].center; };
    const auto requireAt = [](const Vec<3>& found, const Vec<3>& expected) {
        for (int d = 0; d < 3; ++d) {
            CAPTURE(d);
            REQUIRE(found[d] == Approx(expected[d]).margin(1e-12));
        }
    };
    const std::string move = op("double3", "translate", "(10, 20, 30)");
    requireAt(center(move), {{1, 2, 3}});  // not in the order: not applied
    requireAt(center(move + order("\"xformOp:translate\"")), {{11, 22, 33}});
    const std::string scale = op("float3", "scale", "(2, 2, 2)");
    // The last one is applied first.
    requireAt(center(move + scale + order("\"xformOp:translate\", \"xformOp:scale\"")),
              {{12, 24, 36}});
    requireAt(center(move + scale + order("\"xformOp:scale\", \"xformOp:translate\"")),
              {{22, 44, 66}});
    REQUIRE(placed(scale + order("\"xformOp:scale\""))[1].radius == 2);
    requireAt(center(op("float", "rotateZ", "90") + order("\"xformOp:rotateZ\"")), {{-2, 1, 3}});
    requireAt(center(op("float", "rotateX:t", "90") + order("\"xformOp:rotateX:t\"")),
              {{1, -3, 2}});
    // About x first, then y: (1, 2, 3) to (1, -3, 2) to (2, -3, -1).
    requireAt(center(op("float3", "rotateXYZ", "(90, 90, 0)") + order("\"xformOp:rotateXYZ\"")),
              {{2, -3, -1}});
    requireAt(center(op("quatf", "orient", "(0.70710678118654752, 0, 0, 0.70710678118654752)") +
                     order("\"xformOp:orient\"")),
              {{-2, 1, 3}});
    requireAt(center(op("matrix4d", "transform",
                        "( (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (5, 6, 7, 1) )") +
                     order("\"xformOp:transform\"")),
              {{3, 7, 10}});
    requireAt(center(op("float3", "translate:pivot", "(1, 0, 0)") + op("float", "rotateZ", "90") +
                     order("\"xformOp:translate:pivot\", \"xformOp:rotateZ\", "
                           "\"!invert!xformOp:translate:pivot\"")),
              {{-1, 0, 3}});
    requireAt(center(op("float", "rotateZ", "30") +
                     order("\"xformOp:rotateZ\", \"!invert!xformOp:rotateZ\"")),
              {{1, 2, 3}});
    REQUIRE_THAT(errorOf("p.usda", stageOf(kTwo, op("float3", "scale", "(1, 1, 2)") +
                                                     order("\"xformOp:scale\""))),
                 Contains("ellipsoids"));
    REQUIRE_THAT(errorOf("p.usda", stageOf(kTwo, op("float3", "shear", "(1, 1, 2)") +
                                                     order("\"xformOp:shear\""))),
                 Contains("shear"));
}

TEST_CASE("a prim may leave the transformations around it", "[formats][usd]") {
    const std::string own =
        "double3 xformOp:translate = (1, 1, 1)\n"
        "uniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:translate\"]\n";
    // The transformation of the prim around comes after the points in the file, too.
    const auto text = stageOf(kTwo + own);
    const auto end = text.rfind('}');
    const auto moved = text.substr(0, end) +
                       "double3 xformOp:translate = (50, 0, 0)\n"
                       "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}\n";
    REQUIRE(readText("p.usda", moved).spheres[0].center == Vec<3>{{2, 3, 4}});
    auto kept = moved;
    kept.erase(kept.find("\"!resetXformStack!\", "), std::strlen("\"!resetXformStack!\", "));
    REQUIRE(readText("p.usda", kept).spheres[0].center == Vec<3>{{52, 3, 4}});
}

TEST_CASE("a broken .usda file is refused with place and remedy", "[formats][usd]") {
    const std::string points = "point3f[] points = [(1, 2, 3)]\n";
    const auto [content, word] = GENERATE_COPY(table<std::string, std::string>({
        {"", "#usda"},
        {"PXR-USDC\1\2\3", "usdcat"},
        {"#usda 1.0\n", "no Points prim"},
        {"#usda 1.0\n(", "line 2"},
        {"#usda 1.0\n( metersPerUnit = 0.0254 )\n", "0.0254"},
        {"#usda 1.0\ndef Points \"a\" {", "cut short"},
        {"#usda 1.0\ndef Points \"a {\n}", "closing quote"},
        {"#usda 1.0\n/* def", "comment"},
        {"#usda 1.0\n}", "prim or an attribute"},
        {stageOf(points), "widths"},
        {stageOf(points + "float[] widths = []\n"), "widths"},
        {stageOf(points + "float[] widths = [1, 2]\n"), "2 values for 1 points"},
        {stageOf(points + "int[] widths = [1]\n"), "widths"},
        {stageOf(points + "float[] widths = [(1, 2)]\n"), "widths"},
        {stageOf(points + "float[] widths = [-1]\n"), "radius is -0.5"},
        {stageOf("point3f[] points = [(1, 2)]\nfloat[] widths = [1]\n"), "three coordinates"},
        {stageOf("int3[] points = [(1, 2, 3)]\nfloat[] widths = [1]\n"), "three coordinates"},
        {stageOf("point3f[] points = [(1, 2, 3), (1, 2)]\n"), "line 9"},
        {stageOf("point3f[] points = [(1, 2, x)]\n"), "line 9"},
        {stageOf("point3f[] points = [\"a\"]\n"), "texts for numbers"},
        {stageOf("point3f[] points = [(1, 2, 3), \"a\"]\n"), "numbers and texts"},
        {stageOf("point3f[] points = [(inf, 2, 3)]\nfloat[] widths = [1]\n"), "not finite"},
        {stageOf(points + "float[] widths = [1]\nint64[] ids = [1, 2]\n"), "ids"},
        {stageOf(points + "float[] widths = [1]\nint64[] ids = [1.5]\n"), "1.5"},
        {stageOf(points + "float[] widths = [1]\nint[] primvars:n = [1, 2] (interpolation = "
                          "\"vertex\")\n"),
         "primvars:n"},
        {stageOf(points + "float[] widths = [1]\nint[] primvars:n = [1] (interpolation = "
                          "\"vertex\")\nint[] primvars:n:indices = [1]\n"),
         "index 1"},
    }));
    CAPTURE(content, word);
    REQUIRE_THAT(errorOf("p.usda", content), Contains("p.usda") && Contains(word));
}

TEST_CASE("prims nested without end are refused", "[formats][usd]") {
    std::string text = "#usda 1.0\n";
    for (int i = 0; i < 100000; ++i) text += "def \"a\" {";
    REQUIRE_THAT(errorOf("p.usda", text), Contains("nested deeper"));
    REQUIRE_THAT(errorOf("p.usda", "#usda 1.0\ndef \"a\" { int a = " + std::string(100000, '[')),
                 Contains("cut short"));
}

TEST_CASE("a .usdz begins its file at a multiple of 64 bytes, uncompressed", "[formats][usd]") {
    const auto pack = packWithColumns(7, "n", "t", {"a", "b"});
    const auto bytes = writtenText(pack, "p.usdz");
    const auto text = writtenText(pack, "p.usda");
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

TEST_CASE("a .usdz that is damaged is an error or the same pack", "[formats][usd]") {
    const auto bytes = writtenText(packWithColumns(2, "n", "t", {"a", "b"}), "p.usdz");
    const auto whole = readText("p.usdz", bytes).spheres;
    for (std::size_t size = 0; size < bytes.size(); size += 7)
        REQUIRE_FALSE(errorOf("p.usdz", bytes.substr(0, size)).empty());
    RandomStream random(3, 1);
    for (int trial = 0; trial < 300; ++trial) {
        const auto damaged = withFlippedBits(bytes, 1, random);
        if (errorOf("p.usdz", damaged).empty()) CHECK(readText("p.usdz", damaged).spheres == whole);
    }
    REQUIRE_THAT(errorOf("p.usdz", "not a zip"), Contains("p.usdz"));
}
