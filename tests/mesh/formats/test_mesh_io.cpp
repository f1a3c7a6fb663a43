#include "mesh/formats/vtk_files.h"
#include "support/generators.h"
#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/welding.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack::test {
namespace {

using Catch::Matchers::Contains;

class Folder : public TemporaryFolder {
public:
    std::string write(const std::string& name, const std::string& content) const {
        putContent(file(name), content);
        return file(name);
    }
};

std::string binaryStl(const TriangleMesh& mesh, const std::string& header = "made for a test") {
    std::string out = header;
    out.resize(80, ' ');
    out += rawBytes(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        for (int i = 0; i < 3; ++i) out += rawBytes(0.0f);
        for (const auto v : t)
            for (const double x : mesh.vertices[v].c) out += rawBytes(static_cast<float>(x));
        out += rawBytes(std::uint16_t{0});
    }
    return out;
}

std::string asciiStl(const TriangleMesh& mesh) {
    std::string out = "solid a name with facet in it\n";
    for (const auto& t : mesh.triangles) {
        out += "  facet normal nan nan nan\n    outer loop\n";
        for (const auto v : t)
            out += fmt::format("      vertex {} {} {}\n", mesh.vertices[v][0], mesh.vertices[v][1],
                               mesh.vertices[v][2]);
        out += "    endloop\n  endfacet\n";
    }
    return out + "endsolid a name with facet in it\n";
}

/// `corner` writes a face's corner from the vertex counted from 1 and the number of vertices.
std::string obj(const TriangleMesh& mesh,
                const std::function<std::string(std::uint32_t, std::size_t)>& corner) {
    std::string out = "# comment\nmtllib none.mtl\no bone\n";
    for (const auto& v : mesh.vertices) out += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
    out += "vt 0 0\nvn 0 0 1\ns off\nusemtl none\n";
    for (const auto& t : mesh.triangles) {
        out += "f";
        for (const auto v : t) out += " " + corner(v + 1, mesh.vertices.size());
        out += "\n";
    }
    return out;
}

std::string plainCorner(std::uint32_t v, std::size_t) {
    return std::to_string(v);
}

std::string off(const TriangleMesh& mesh) {
    std::string out =
        fmt::format("OFF # comment\n\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
    for (const auto& v : mesh.vertices) out += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
    for (const auto& t : mesh.triangles)
        out += fmt::format("3 {} {} {} 255 0 0\n", t[0], t[1], t[2]);
    return out;
}

/// With properties in an unusual order, lists among them and an element that means nothing to us.
std::string ply(const TriangleMesh& mesh, const std::string& format) {
    std::string out = fmt::format(
        "ply\nformat {} 1.0\ncomment by a test\nelement camera 2\nproperty list uchar short seen\n"
        "element vertex {}\nproperty uchar red\nproperty double z\nproperty double x\n"
        "property list ushort int used_by\nproperty double y\nelement face {}\n"
        "property float quality\nproperty list uchar uint vertex_indices\nend_header\n",
        format, mesh.vertices.size(), mesh.triangles.size());
    if (format == "ascii") {
        out += "0\n2 -7 8\n";
        for (const auto& v : mesh.vertices)
            out += fmt::format("255 {} {} 1 4 {}\n", v[2], v[0], v[1]);
        for (const auto& t : mesh.triangles)
            out += fmt::format("0.5 3 {} {} {}\n", t[0], t[1], t[2]);
        return out;
    }
    const bool big = format == "binary_big_endian";
    const auto put = [&](auto value) { out += rawBytes(value, big); };
    put(std::uint8_t{0});
    put(std::uint8_t{2});
    put(std::int16_t{-7});
    put(std::int16_t{8});
    for (const auto& v : mesh.vertices) {
        put(std::uint8_t{255});
        put(v[2]);
        put(v[0]);
        put(std::uint16_t{1});
        put(std::int32_t{4});
        put(v[1]);
    }
    for (const auto& t : mesh.triangles) {
        put(0.5f);
        put(std::uint8_t{3});
        for (const auto v : t) put(v);
    }
    return out;
}

TriangleMesh tetrahedron() {
    TriangleMesh mesh;
    mesh.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return mesh;
}

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

TEST_CASE("every format comes back with all its digits", "[mesh]") {
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

TEST_CASE("a file cut off anywhere is refused or gives a sound mesh", "[mesh]") {
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

TEST_CASE("a file with any bytes changed is refused or gives a sound mesh", "[mesh]") {
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

TEST_CASE("binary and ASCII STL are distinguished by content", "[mesh]") {
    const Folder folder;
    const auto mesh = tetrahedron();
    CHECK(readMesh(folder.write("a.stl", binaryStl(mesh, "solid by name only"))).triangles.size() ==
          4);
    CHECK(readMesh(folder.write("b.STL", "\n  SOLID\n" + asciiStl(mesh).substr(30)))
              .triangles.size() == 4);
    // Two solids in one file.
    CHECK(readMesh(folder.write("c.stl", asciiStl(mesh) + asciiStl(mesh))).triangles.size() == 8);
}

TEST_CASE("OBJ corners are read in all their forms", "[mesh]") {
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

TEST_CASE("a prism with concave ends has its area and volume, from any first corner", "[mesh]") {
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
            CrossedFaces crossed;
            requirePrism(readMesh(folder.write(name, text), {}, &crossed));
            CHECK(crossed.count == 0);
        }
    }
}

TEST_CASE("faces whose outline crosses itself are counted, the first by its place", "[mesh]") {
    const Folder folder;
    MeshReadOptions options;
    options.unit = Unit::centimeter;
    CrossedFaces crossed;
    readMesh(folder.write("a.obj",
                          "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 2 1\nv 7 4 1\nv 7 2 1\nv 5 4 1\n"
                          "f 1 2 3\nf 4 5 6 7\n"),
             options, &crossed);
    CHECK(crossed.count == 1);
    CHECK(crossed.firstAt == Vec<3>{{50, 20, 10}});
}

TEST_CASE("an index of an OBJ beyond all vertices that can be read is out of range", "[mesh]") {
    const Folder folder;
    const std::string file = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4294967299\n");
    const std::string message = messageOf<InputError>([&] { readMesh(file); });
    CHECK_THAT(message, Contains(file) && Contains("line 4") && Contains("4294967299") &&
                            Contains("range") && !Contains("from 1"));
}

TEST_CASE("vertices with the same coordinates are welded, unused ones dropped", "[mesh]") {
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

TEST_CASE("welding twice is welding once, and agrees with a comparison of all pairs", "[mesh]") {
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

TEST_CASE("coordinates come back in millimeters", "[mesh]") {
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

/// Writes files that must be refused. @return the message of the refusal, which names the file.
class RefusedFiles : public Folder {
public:
    std::string refusal(const std::string& name, const std::string& content) const {
        const auto path = write(name, content);
        CHECK_THROWS_AS(readMesh(path), InputError);
        const auto message = messageOf<Error>([&] { readMesh(path); });
        CHECK_THAT(message, Contains(path));
        return message;
    }
};

TEST_CASE("files that are missing, of an unknown format or without triangles are refused",
          "[mesh]") {
    const RefusedFiles folder;
    CHECK_THROWS_AS(readMesh(folder.file("none.stl")), IoError);
    CHECK_THAT(messageOf<Error>([&] { readMesh(folder.file("none.stl")); }), Contains("none.stl"));
    std::filesystem::create_directory(folder.file("f.stl"));
    CHECK_THROWS_AS(readMesh(folder.file("f.stl")), IoError);
    CHECK_THAT(folder.refusal("skull.3mf", "x"), Contains("'.3mf'") && Contains(".stl"));
    CHECK_THAT(folder.refusal("noextension", "x"), Contains(".stl"));
    for (const auto* name : {"e.stl", "e.obj", "e.ply", "e.off"})
        CHECK_THAT(folder.refusal(name, ""), Contains(name));
    CHECK_THAT(folder.refusal("n.stl", "solid x\nendsolid x\n"), Contains("n.stl"));
    CHECK_THAT(folder.refusal("n.stl", binaryStl({})), Contains("n.stl"));
    CHECK_THAT(folder.refusal("n.obj", "v 0 0 0\n"), Contains("n.obj"));
    CHECK_THAT(folder.refusal("n.off", "OFF\n1 0 0\n0 0 0\n"), Contains("n.off"));
    CHECK_THAT(folder.refusal("n.ply",
                              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                              "property float y\nproperty float z\nend_header\n0 0 0\n"),
               Contains("faces"));
}

TEST_CASE("images are refused as meshes, with what takes them", "[mesh]") {
    const RefusedFiles folder;
    for (const auto* name : {"a.nii", "a.nii.gz", "a.seg.nrrd", "a.MHA", "a.mhd", "a.dcm"})
        CHECK_THAT(folder.refusal(name, "x"),
                   Contains("image") && Contains("threshold") && Contains(".stl"));
    std::filesystem::create_directory(folder.file("dicom"));
    CHECK_THAT(messageOf<InputError>([&] { readMesh(folder.file("dicom")); }),
               Contains("dicom") && Contains("folder") && Contains(".stl"));
}

TEST_CASE("coordinates that are not finite or too large are refused with line or byte", "[mesh]") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nv 0 nan 0\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 1e999 0\n"), Contains("line 1"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 2e9\n"), Contains("line 1") && Contains("unit"));
    CHECK_THAT(folder.refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n"),
               Contains("line 4"));
    auto mesh = tetrahedron();
    mesh.vertices[2][1] = std::numeric_limits<double>::quiet_NaN();
    CHECK_THAT(folder.refusal("a.stl", binaryStl(mesh)),
               Contains("byte 108") && Contains("triangle 0"));
    CHECK_THAT(folder.refusal("a.ply", ply(mesh, "binary_big_endian")), Contains("vertex 2"));
    MeshReadOptions meters;
    meters.unit = Unit::meter;
    const auto path = folder.write("m.obj", "v 0 0 0\nv 2e6 0 0\nv 0 1 0\nf 1 2 3\n");
    CHECK(readMesh(path).vertices.size() == 3);
    CHECK_THROWS_AS(readMesh(path, meters), InputError);
}

TEST_CASE("a coordinate too small for double is zero", "[mesh]") {
    const RefusedFiles folder;
    const auto path = folder.write("a.obj", "v 1e-999 0 -1E-400\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    CHECK(readMesh(path).vertices[0] == Vec<3>{});
}

TEST_CASE("indices of vertices out of range are refused with line or face", "[mesh]") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n"),
               Contains("line 5") && Contains("vertex 4"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 0 1\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 -2 1\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 99999999999999 1\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
               Contains("line 6") && Contains("vertex 3"));
    auto mesh = tetrahedron();
    mesh.triangles[3][1] = 4;
    CHECK_THAT(folder.refusal("a.ply", ply(mesh, "binary_little_endian")),
               Contains("face 3") && Contains("vertex 4"));
    CHECK_THAT(folder.refusal("b.ply", ply(mesh, "ascii")), Contains("face 3") && Contains("line"));
}

TEST_CASE("wrong counts are refused", "[mesh]") {
    const RefusedFiles folder;
    auto stl = binaryStl(tetrahedron());
    stl.replace(80, 4, rawBytes(std::uint32_t{0xffffffff}));
    CHECK_THAT(folder.refusal("a.stl", stl), Contains("4294967295"));
    stl.replace(80, 4, rawBytes(std::uint32_t{3}));
    CHECK_THAT(folder.refusal("b.stl", stl), Contains("3 triangles"));
    CHECK_THAT(folder.refusal("c.stl", "hello"), Contains("c.stl"));
    CHECK_THAT(folder.refusal("a.off", "OFF\n4000000000000000000 1 0\n0 0 0\n"),
               Contains("4000000000000000000"));
    CHECK_THAT(folder.refusal("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"),
               Contains("line 7"));
    CHECK_THAT(folder.refusal("c.off", "OFF\n-3 1 0\n"), Contains("-3"));
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
    const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\n";
    CHECK_THAT(
        folder.refusal("a.ply", head + "4000000000" + xyz +
                                    "element face 1\nproperty list uchar int vertex_indices\n"
                                    "end_header\n"),
        Contains("too many"));
    CHECK_THAT(
        folder.refusal("b.ply", head + "1" + xyz +
                                    "element face 1\nproperty list int int vertex_indices\n"
                                    "end_header\n" +
                                    std::string(12, '\0') + rawBytes(std::int32_t{2000000000})),
        Contains("2000000000"));
    CHECK_THAT(folder.refusal("c.ply", ply(tetrahedron(), "binary_little_endian") + "more"),
               Contains("c.ply"));
}

TEST_CASE("text that is not of the format is refused with its line", "[mesh]") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 zero\n"), Contains("line 1") && Contains("'zero'"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0\n"), Contains("line 1"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 1\n"), Contains("2 corners"));
    CHECK_THAT(folder.refusal("a.obj", "v 0,5 0 0\n"), Contains("'0,5'"));
    CHECK_THAT(folder.refusal("a.obj", std::string("\x01\x02\x03", 3)), Contains("line 1"));
    CHECK_THAT(folder.refusal("a.off", "OFF BINARY\n"), Contains("binary"));
    CHECK_THAT(folder.refusal("a.off", "4OFF\n3 1 0\n"), Contains("'4OFF'"));
    CHECK_THAT(folder.refusal("a.ply", "plyx\n"), Contains("'ply'"));
    CHECK_THAT(
        folder.refusal("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n"),
        Contains("line 4") && Contains("'half'"));
}

TEST_CASE("OFF is read with colors, normals and without its first word", "[mesh]") {
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

TEST_CASE("a PLY header of any length is read in proportion", "[mesh]") {
    const Folder folder;
    std::string text = "ply\nformat ascii 1.0\n";
    for (int i = 0; i < 200'000; ++i) text += fmt::format("element e{} 0\n", i);
    CHECK_THROWS_AS(readMesh(folder.write("a.ply", text + "element e7 0\nend_header\n")),
                    InputError);
}

TEST_CASE("lines longer than the buffer are read", "[mesh]") {
    const Folder folder;
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n# " + std::string(9'000'000, 'x') + "\nf 1 2";
    text += std::string(5'000'000, ' ') + "3\n";
    CHECK(readMesh(folder.write("a.obj", text)).triangles.size() == 1);
}

}  // namespace
}  // namespace vdbpack::test
