#include "mesh/formats/mesh_files.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/welding.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace {

struct Sample {
    std::string name;
    std::string content;
};

/// One file of every format and encoding.
std::vector<Sample> samples(const TriangleMesh& mesh) {
    return {{"b.stl", binaryStl(mesh)},
            {"a.stl", asciiStl(mesh)},
            {"a.obj", obj(mesh, plainCorner)},
            {"a.off", off(mesh)},
            {"a.gts", gts(mesh)},
            {"a.ply", ply(mesh, "ascii")},
            {"l.ply", ply(mesh, "binary_little_endian")},
            {"b.ply", ply(mesh, "binary_big_endian")},
            {"a.vtp", vtpText(mesh.vertices, polygonsOf(mesh), "ascii")},
            {"b.vtp", vtpText(mesh.vertices, polygonsOf(mesh), "raw")},
            {"a.vtk", vtkText(mesh.vertices, polygonsOf(mesh), false)},
            {"b.vtk", vtkText(mesh.vertices, polygonsOf(mesh), true)},
            {"c.vtk", vtkText(mesh.vertices, polygonsOf(mesh), true, true)}};
}

/// The corners of all triangles, in order.
std::vector<Vec<3>> corners(const TriangleMesh& mesh) {
    std::vector<Vec<3>> all;
    for (const auto& t : mesh.triangles)
        for (const auto v : t) all.push_back(mesh.vertices.at(v));
    return all;
}

Callbacks keptIn(std::string& warnings) {
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings += text; };
    return callbacks;
}

/// `text` with `more` behind the first `mark`.
std::string inserted(std::string text, const std::string& mark, const std::string& more) {
    return text.insert(text.find(mark) + mark.size(), more);
}

}  // namespace

TEST_CASE("every format comes back with all its digits") {
    const Folder folder;
    const auto mesh =
        translated(rotated(torusMesh(5, 2, 11, 7), {{1, 2, 3}}, 1.0), {{-730, 1000.0 / 3, 80}});
    for (const auto& sample : samples(mesh)) {
        CAPTURE(sample.name);
        const auto read = readMesh(folder.write(sample.name, sample.content));
        REQUIRE(read.vertices.size() == mesh.vertices.size());
        if (sample.name == "b.stl") {
            // volatile: GCC 12 at -O3 (SLP) drops the rounding of x = double(float(x)) in place.
            const auto floats = mapped(mesh, [](Vec<3> v) {
                for (auto& x : v.c) {
                    const volatile float rounded = static_cast<float>(x);
                    x = static_cast<double>(rounded);
                }
                return v;
            });
            CHECK(corners(read) == corners(floats));
        } else {
            CHECK(corners(read) == corners(mesh));
        }
        if (sample.name.find("stl") == std::string::npos) {
            // Formats with vertices keep their order.
            CHECK(read.vertices == mesh.vertices);
            CHECK(read.triangles == mesh.triangles);
        }
    }
}

TEST_CASE("a file cut off anywhere is refused or gives a sound mesh") {
    const Folder folder;
    for (const auto& sample : samples(tetrahedron())) {
        for (std::size_t n = 0; n <= sample.content.size(); ++n) {
            CAPTURE(sample.name, n);
            const auto path = folder.write(sample.name, sample.content.substr(0, n));
            try {
                const auto mesh = readMesh(path);
                REQUIRE(!mesh.triangles.empty());
                for (const auto& p : corners(mesh)) REQUIRE(isFinite(p));
                // Only text without counts can lose its end unnoticed, and a last line end.
                if (sample.name != "a.obj") REQUIRE(n + 1 >= sample.content.size() - 40);
            } catch (const InputError& e) {
                REQUIRE_THAT(e.what(), Contains(path));
                REQUIRE(n < sample.content.size());
            }
        }
    }
}

TEST_CASE("a file with any bytes changed is refused or gives a sound mesh") {
    const Folder folder;
    const auto seed = GENERATE(range(1u, 5u));
    CAPTURE(seed);
    RandomStream random(seed, 2);
    for (const auto& sample : samples(tetrahedron()))
        for (int round = 0; round < 400; ++round) {
            std::string content = sample.content;
            for (std::uint64_t k = 0; k <= random.bits() % 3; ++k) {
                const std::size_t at = random.bits() % content.size();
                content[at] = static_cast<char>(random.bits() % 256);
                // Digits and signs get further into a text than noise does.
                if (random.bits() % 2 == 0) content[at] = "0123456789-+.e \n/"[random.bits() % 17];
            }
            CAPTURE(sample.name, round);
            try {
                const auto mesh = readMesh(folder.write(sample.name, content));
                REQUIRE(!mesh.triangles.empty());
                for (const auto& p : corners(mesh)) REQUIRE(isFinite(p));
            } catch (const Error&) {
                SUCCEED("refused");
            }
        }
}

TEST_CASE("binary and ASCII STL are distinguished by content") {
    const Folder folder;
    const auto mesh = tetrahedron();
    CHECK(readMesh(folder.write("a.stl", binaryStl(mesh, "solid by name only"))).triangles.size() ==
          4);
    CHECK(readMesh(folder.write("b.STL", "\n  SOLID\n" + asciiStl(mesh).substr(30)))
              .triangles.size() == 4);
    // Two solids in one file.
    CHECK(readMesh(folder.write("c.stl", asciiStl(mesh) + asciiStl(mesh))).triangles.size() == 8);
}

TEST_CASE("OBJ corners are read in all their forms") {
    const Folder folder;
    const auto mesh = tetrahedron();
    const auto same = [&](const std::string& text) {
        const auto read = readMesh(folder.write("a.obj", text));
        return read.vertices == mesh.vertices && read.triangles == mesh.triangles;
    };
    CHECK(same(obj(mesh, [](auto v, auto) { return fmt::format("{}/1", v); })));
    CHECK(same(obj(mesh, [](auto v, auto) { return fmt::format("{}//1", v); })));
    CHECK(same(obj(mesh, [](auto v, auto) { return fmt::format("{}/1/1", v); })));
    CHECK(same(obj(mesh, [](auto v, auto n) {
        return std::to_string(static_cast<long>(v) - static_cast<long>(n) - 1);
    })));
    // Windows line ends, tabs, weights and colors, a continued line, plus signs.
    CHECK(
        same("v\t0 0 0 1\r\nv +1 0 0\r\nv 0 1.0e0 0 0.5 0.5 0.5\r\nv 0 0 1\r\nf 1 3 2\r\n"
             "f 1 2 \\\r\n 4\r\nf 1 4 3\r\nf 2 3 4"));
    // Line ends of old Mac software.
    CHECK(same("v 0 0 0\rv 1 0 0\rv 0 1 0\rv 0 0 1\rf 1 3 2\rf 1 2 \\\r 4\rf 1 4 3\rf 2 3 4\r"));
    // Faces before their vertices.
    CHECK(same("f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"));
}

TEST_CASE("a prism with concave ends has its area and volume, from any first corner") {
    const Folder folder;
    for (std::uint32_t first = 0; first < 6; ++first) {
        const Prism prism(first);
        std::string points, off, obj;
        for (const auto& v : prism.vertices) points += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
        for (const auto& face : prism.faces) {
            off += fmt::format("{} {}\n", face.size(), fmt::join(face, " "));
            obj += "f";
            for (const std::uint32_t v : face) obj += fmt::format(" {}", v + 1);
            obj += "\n";
        }
        // Faces first.
        for (const auto& v : prism.vertices) obj += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
        const std::string ply = fmt::format(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
            "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
            "end_header\n{}{}",
            prism.vertices.size(), prism.faces.size(), points, off);
        off = fmt::format("OFF\n{} {} 0\n{}{}", prism.vertices.size(), prism.faces.size(), points,
                          off);
        for (const auto& [name, text] : {std::pair{"a.off", off}, {"a.ply", ply}, {"a.obj", obj}}) {
            CAPTURE(name, first);
            std::string warning;
            requirePrism(readMesh(folder.write(name, text), {}, keptIn(warning)));
            CHECK(warning.empty());
        }
    }
}

TEST_CASE("faces whose outline crosses itself are counted, the first by its place") {
    const Folder folder;
    MeshReadOptions options;
    options.unit = Unit::centimeter;
    std::string warning;
    readMesh(folder.write("a.obj",
                          "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 2 1\nv 7 4 1\nv 7 2 1\nv 5 4 1\n"
                          "f 1 2 3\nf 4 5 6 7\n"),
             options, keptIn(warning));
    CHECK_THAT(warning, Contains("of 1 faces") && Contains("(50, 20, 10)"));
}

TEST_CASE("vertices with the same coordinates are welded, unused ones dropped") {
    const Folder folder;
    const auto mesh = readMesh(folder.write("a.obj",
                                            "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 -0\n"
                                            "v 0 1 -0.0\nv 1 1 0\nf 2 3 4\nf 5 7 6\n"));
    CHECK(mesh.vertices.size() == 4);
    CHECK(mesh.triangles == decltype(mesh.triangles){{0, 1, 2}, {1, 3, 2}});
    for (const auto& v : mesh.vertices)
        for (const double x : v.c) CHECK(!std::signbit(x));
    // Neighbors in the last digit stay apart.
    CHECK(readMesh(folder.write("b.obj",
                                "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.0000000000000002 0 0\nv 0 1 0\n"
                                "v 1 1 0\nf 1 2 3\nf 4 6 5\n"))
              .vertices.size() == 5);
}

TEST_CASE("welding twice is welding once, and agrees with a comparison of all pairs") {
    const auto seed = GENERATE(range(1u, 11u));
    CAPTURE(seed);
    RandomStream random(seed, 3);
    TriangleMesh soup;
    for (int i = 0; i < 300; ++i) {
        Vec<3> p;
        for (auto& x : p.c) x = (random.bits() % 2 == 0 ? -1.0 : 1.0) * double(random.bits() % 3);
        soup.vertices.push_back(p);
    }
    const auto any = [&] { return static_cast<std::uint32_t>(random.bits() % 300); };
    for (int i = 0; i < 60; ++i) soup.triangles.push_back({any(), any(), any()});
    std::vector<Vec<3>> distinct;
    for (const auto& p : corners(soup))
        if (std::find(distinct.begin(), distinct.end(), p) == distinct.end()) distinct.push_back(p);
    const auto once = welded(soup);
    CHECK(once.vertices.size() == distinct.size());
    CHECK(corners(once) == corners(soup));
    const auto twice = welded(once);
    CHECK(twice.vertices == once.vertices);
    CHECK(twice.triangles == once.triangles);
}

TEST_CASE("coordinates come back in millimeters") {
    const Folder folder;
    const auto path = folder.write("a.obj", obj(tetrahedron(), plainCorner));
    MeshReadOptions options;
    options.unit = Unit::meter;
    options.scale = 0.5;
    CHECK(readMesh(path, options).vertices[1] == Vec<3>{{500, 0, 0}});
    options.unit = Unit::micrometer;
    options.scale = 1;
    CHECK(readMesh(path, options).vertices[1] == Vec<3>{{0.001, 0, 0}});
    for (const double scale : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
        options.scale = scale;
        CHECK_THROWS_AS(readMesh(path, options), ParameterError);
    }
}

TEST_CASE("a coordinate too small for double is zero") {
    const Folder folder;
    const auto path = folder.write("a.obj", "v 1e-999 0 -1E-400\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    CHECK(readMesh(path).vertices[0] == Vec<3>{});
}

TEST_CASE("OFF is read with colors, normals and without its first word") {
    const Folder folder;
    CHECK(readMesh(folder.write("a.off",
                                "COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 0 0 1 1\n"
                                "3 0 1 2\n"))
              .vertices.size() == 3);
    CHECK(readMesh(folder.write("b.off", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2")).vertices.size() ==
          3);
    CHECK(readMesh(folder.write("c.off", "OFF 3 1 0\n0 0 0\n# half\n\n1 0 0\n0 1 0\n3 0 1 2"))
              .vertices.size() == 3);
}

TEST_CASE("lines longer than the buffer are read") {
    const Folder folder;
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n# " + std::string(9'000'000, 'x') + "\nf 1 2";
    text += std::string(5'000'000, ' ') + "3\n";
    CHECK(readMesh(folder.write("a.obj", text)).triangles.size() == 1);
}

TEST_CASE("a unit in the header of a binary .stl counts") {
    const TemporaryFolder folder;
    const auto mesh = boxMesh({{0, 0, 0}}, {{40, 48, 56}});
    const auto unit = GENERATE(Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer);
    writeStl(mesh, folder.file("s.stl"), unit, "a program");
    MeshReadOptions options;
    options.unit = GENERATE(Unit::millimeter, Unit::meter);
    options.scale = 2;
    std::string warning;
    const Vec<3> size = readMesh(folder.file("s.stl"), options, keptIn(warning)).bounds().size();
    for (int d = 0; d < 3; ++d) CHECK(size[d] == Approx(2 * (40 + 8 * d)));
    CHECK(warning.empty() == (options.unit == Unit::millimeter || options.unit == unit));
}

TEST_CASE("centimeters that a .obj of Maya states are a warning unless a unit is set") {
    const Folder folder;
    const auto path = folder.write(
        "m.obj", "# This file uses centimeters as units for non-parametric coordinates.\n\n" +
                     obj(tetrahedron(), plainCorner));
    MeshReadOptions options;
    options.unit = GENERATE(Unit::millimeter, Unit::centimeter);
    const bool isSet = options.unit != Unit::millimeter;
    std::string warning;
    CHECK(readMesh(path, options, keptIn(warning)).vertices[1][0] == (isSet ? 10 : 1));
    CHECK(warning.empty() == isSet);
    if (!isSet) CHECK_THAT(warning, Contains("m.obj") && Contains("`unit` cm") && Contains("10"));
}

TEST_CASE("axes that a file of 3D Slicer states are used in every format") {
    const Folder folder;
    const auto mesh = tetrahedron();
    const std::string stated = GENERATE(as<std::string>{}, "RAS", "LPS", "");
    const std::string space = stated.empty() ? "" : "SPACE=" + stated;
    std::string codes;  // of the characters
    for (const char c : stated) codes += fmt::format("{} ", static_cast<int>(c));
    const std::string field = fmt::format(
        "<FieldData><Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" "
        "format=\"ascii\">{} 0</Array></FieldData>",
        codes);
    const auto vtk = vtkText(mesh.vertices, polygonsOf(mesh), true);
    MeshReadOptions options;
    options.space = GENERATE(ImageSpace::lps, ImageSpace::ras);
    const bool turned = stated == (options.space == ImageSpace::lps ? "RAS" : "LPS");
    const double sign = turned ? -1 : 1;
    for (const Sample& sample : std::vector<Sample>{
             {"b.stl", binaryStl(mesh, "3D Slicer output. " + space)},
             {"a.stl", inserted(asciiStl(mesh), "solid", " 3D Slicer output. " + space)},
             {"a.obj", "# 3D Slicer output. " + space + "\n" + obj(mesh, plainCorner)},
             {"b.ply",
              inserted(ply(mesh, "binary_big_endian"), "1.0\n", "comment " + space + "\n")},
             {"b.vtk", inserted(vtk, "\n", space + " ")},
             {"a.vtp",
              inserted(vtpText(mesh.vertices, polygonsOf(mesh), "ascii"), "<PolyData>", field)}}) {
        CAPTURE(sample.name, stated, turned);
        std::string warning;
        const auto read =
            readMesh(folder.write(sample.name, sample.content), options, keptIn(warning));
        CHECK(checkMesh(read).signedVolume == Approx(checkMesh(mesh).signedVolume));
        const auto have = corners(read), want = corners(mesh);
        for (std::size_t i = 0; i < want.size(); ++i)
            CHECK(have[i] ==
                  Vec<3>{{sign * want[i][0] + 0.0, sign * want[i][1] + 0.0, want[i][2]}});
        CHECK(warning.empty() == !turned);
        if (turned) CHECK_THAT(warning, Contains(sample.name) && Contains(space));
    }
}
