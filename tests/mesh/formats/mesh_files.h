// Files of meshes in every format, written as other programs would.
#pragma once

#include "mesh/formats/vtk_files.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/mesh/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

namespace vdbpack::test {

class Folder : public TemporaryFolder {
public:
    std::string write(const std::string& name, const std::string& content) const {
        putContent(file(name), content);
        return file(name);
    }
};

inline std::string binaryStl(const TriangleMesh& mesh,
                             const std::string& header = "made for a test") {
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

inline std::string asciiStl(const TriangleMesh& mesh) {
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
inline std::string obj(const TriangleMesh& mesh,
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

inline std::string plainCorner(std::uint32_t v, std::size_t) {
    return std::to_string(v);
}

/// GTS: each edge once, with the lower vertex first.
inline std::string gts(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> edges;
    std::string vertices, between, faces;
    for (const auto& v : mesh.vertices) vertices += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto ends = std::minmax(t[k], t[(k + 1) % 3]);
            const auto [edge, added] = edges.emplace(ends, edges.size() + 1);
            if (added) between += fmt::format("{} {}\n", ends.first + 1, ends.second + 1);
            faces += fmt::format("{}{}", edge->second, k == 2 ? "\n" : " ");
        }
    }
    return fmt::format("# edges\n{} {} {} GtsSurface GtsFace GtsEdge GtsVertex\n{}{}{}",
                       mesh.vertices.size(), edges.size(), mesh.triangles.size(), vertices, between,
                       faces);
}

inline std::string off(const TriangleMesh& mesh) {
    std::string out =
        fmt::format("OFF # comment\n\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
    for (const auto& v : mesh.vertices) out += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
    for (const auto& t : mesh.triangles)
        out += fmt::format("3 {} {} {} 255 0 0\n", t[0], t[1], t[2]);
    return out;
}

/// With properties in an unusual order, lists among them and an element that means nothing to us.
inline std::string ply(const TriangleMesh& mesh, const std::string& format) {
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

inline TriangleMesh tetrahedron() {
    TriangleMesh mesh;
    mesh.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return mesh;
}

}  // namespace vdbpack::test
