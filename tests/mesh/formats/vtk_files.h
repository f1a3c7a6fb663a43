// Meshes as the text of .vtp and .vtk files, in all their encodings.
#pragma once

#include "support/vtk_encoding.h"

#include "vdbpack/mesh/mesh_check.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack::test {

using Polygons = std::vector<std::vector<std::uint32_t>>;

inline Polygons polygonsOf(const TriangleMesh& mesh) {
    Polygons polygons;
    for (const auto& t : mesh.triangles) polygons.push_back({t[0], t[1], t[2]});
    return polygons;
}

/// A prism with concave ends: polygons of six and of four corners.
struct Prism {
    std::vector<Vec<3>> vertices;
    Polygons faces;

    /// @param first  the corner that the ends begin with.
    explicit Prism(std::uint32_t first = 0) : faces(2) {
        constexpr double kOutline[6][2] = {{0, 0}, {30, 0}, {30, 10}, {10, 10}, {10, 40}, {0, 40}};
        for (const double z : {0.0, 20.0})
            for (const auto& p : kOutline) vertices.push_back({{p[0], p[1], z}});
        for (std::uint32_t k = 0; k < 6; ++k) {
            const std::uint32_t at = (first + k) % 6, next = (at + 1) % 6;
            faces[0].insert(faces[0].begin(), at);
            faces[1].push_back(at + 6);
            faces.push_back({at, next, next + 6, at + 6});
        }
    }
};

inline void requirePrism(const TriangleMesh& mesh) {
    const MeshHealth health = checkMesh(mesh);
    CHECK(health.isWatertight());
    CHECK(health.area == Approx(4000));
    CHECK(health.signedVolume == Approx(12000));
}

template <class T>
std::string rawBytes(T value, bool bigEndian = false) {
    std::string out(sizeof value, '\0');
    std::memcpy(out.data(), &value, sizeof value);
    if (bigEndian) std::reverse(out.begin(), out.end());
    return out;
}

/// A .vtp of one piece; its arrays are "ascii", "binary" (base64) or "raw" (appended).
inline std::string vtpText(const std::vector<Vec<3>>& vertices, const Polygons& faces,
                           const std::string& format, bool zlib = false, bool strips = false) {
    std::string appended;
    const auto encoded = [&](const std::string& data) {
        if (!zlib) return std::pair{rawBytes(static_cast<std::uint32_t>(data.size())), data};
        const std::string packed = deflated(data);
        std::string header;
        for (const std::size_t n : {std::size_t{1}, data.size(), std::size_t{0}, packed.size()})
            header += rawBytes(static_cast<std::uint32_t>(n));
        return std::pair{header, packed};
    };
    const auto array = [&](const std::string& tag, const std::string& text,
                           const std::string& data) {
        if (format == "ascii")
            return fmt::format("<DataArray {} format=\"ascii\">\n{}</DataArray>\n", tag, text);
        const auto [header, body] = encoded(data);
        if (format == "binary")
            return fmt::format("<DataArray {} format=\"binary\">{}</DataArray>\n", tag,
                               zlib ? base64(header) + base64(body) : base64(header + body));
        const std::size_t offset = appended.size();
        appended += header + body;
        return fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"/>\n", tag, offset);
    };
    std::string points, pointData, corners, cornerData, ends, endData;
    for (const auto& v : vertices)
        for (const double x : v.c) {
            points += fmt::format("{} ", x);
            pointData += rawBytes(x, false);
        }
    std::int64_t end = 0;
    for (const auto& face : faces) {
        for (const std::uint32_t v : face) {
            corners += fmt::format("{} ", v);
            cornerData += rawBytes(std::int64_t{v}, false);
        }
        ends += fmt::format("{} ", end += static_cast<std::int64_t>(face.size()));
        endData += rawBytes(static_cast<std::int32_t>(end), false);
    }
    const char* const section = strips ? "Strips" : "Polys";
    std::string out = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
        "byte_order=\"LittleEndian\"{}>\n<PolyData>\n<Piece NumberOfPoints=\"{}\" "
        "NumberOfVerts=\"0\" NumberOf{}=\"{}\">\n<PointData/>\n<Points>\n",
        zlib ? " compressor=\"vtkZLibDataCompressor\"" : "", vertices.size(), section,
        faces.size());
    out += array("type=\"Float64\" NumberOfComponents=\"3\"", points, pointData);
    out += fmt::format("</Points>\n<{}>\n", section);
    out += array("type=\"Int64\" Name=\"connectivity\"", corners, cornerData);
    out += array("type=\"Int32\" Name=\"offsets\"", ends, endData);
    out += fmt::format("</{}>\n</Piece>\n</PolyData>\n", section);
    if (format == "raw") out += "<AppendedData encoding=\"raw\">_" + appended + "</AppendedData>\n";
    return out + "</VTKFile>\n";
}

/// A legacy .vtk. `offsets`: cells as since version 5, after a METADATA block.
inline std::string vtkText(const std::vector<Vec<3>>& vertices, const Polygons& faces, bool binary,
                           bool offsets = false, const std::string& cells = "POLYGONS") {
    std::string out = fmt::format("# vtk DataFile Version {}\na bone\n{}\nDATASET {}\n",
                                  offsets ? "5.1" : "3.0", binary ? "BINARY" : "ASCII",
                                  cells == "CELLS" ? "UNSTRUCTURED_GRID" : "POLYDATA");
    const auto put = [&](auto value) {
        out += binary ? rawBytes(value, true) : fmt::format("{} ", value);
    };
    out += fmt::format("POINTS {} double\n", vertices.size());
    for (const auto& v : vertices)
        for (const double x : v.c) put(x);
    out += "\n";
    if (offsets) out += "METADATA\nINFORMATION 0\n\n";
    std::size_t corners = 0;
    for (const auto& face : faces) corners += face.size();
    if (offsets) {
        out += fmt::format("{} {} {}\nOFFSETS vtktypeint64\n", cells, faces.size() + 1, corners);
        std::int64_t end = 0;
        put(end);
        for (const auto& face : faces) put(end += static_cast<std::int64_t>(face.size()));
        out += "\nCONNECTIVITY vtktypeint64\n";
        for (const auto& face : faces)
            for (const std::uint32_t v : face) put(std::int64_t{v});
    } else {
        out += fmt::format("{} {} {}\n", cells, faces.size(), faces.size() + corners);
        for (const auto& face : faces) {
            put(static_cast<std::int32_t>(face.size()));
            for (const std::uint32_t v : face) put(static_cast<std::int32_t>(v));
        }
    }
    out += "\n";
    if (cells == "CELLS") {
        out += fmt::format("CELL_TYPES {}\n", faces.size());
        for (const auto& face : faces)
            put(std::int32_t{face.size() == 3 ? 5 : face.size() == 4 ? 9 : 7});
        out += "\n";
    }
    return out + fmt::format("POINT_DATA {}\n", vertices.size());
}

}  // namespace vdbpack::test
