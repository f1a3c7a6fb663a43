// Stanford polygon files, text or binary, with faces.
#include "vdbpack/io/ply_header.h"
#include "vdbpack/mesh/formats/mesh_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

namespace vdbpack {

namespace {

/// Values of a PLY body.
class PlyValues : public MeshValues {
public:
    PlyValues(MeshReader& reader, PlyFormat format)
        : MeshValues(reader, format == PlyFormat::ascii, format == PlyFormat::bigEndian),
          file_(reader.file) {}

    /// The length of a list, checked against what is left of the file.
    std::uint64_t listLength(const PlyProperty& property) {
        const std::int64_t n = integer(property.countType);
        // A list in text ends with the words that are there.
        if (n < 0 || (!isText() &&
                      static_cast<std::uint64_t>(n) > file_.remaining() / bytesOf(property.type)))
            fail(fmt::format(
                "list of {} values, more than the file holds; it is truncated or broken", n));
        return static_cast<std::uint64_t>(n);
    }
    void skip(const PlyProperty& property) {
        MeshValues::skip(property.type, property.isList ? listLength(property) : 1);
    }

private:
    const InputFile& file_;
};

void readPlyVertices(MeshReader& reader, PlyValues& values, const PlyElement& element) {
    std::vector<int> axisOf(element.properties.size(), -1);
    std::array<int, 3> found{};
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const auto& property = element.properties[k];
        for (int d = 0; d < 3; ++d)
            if (!property.isList && property.name == std::string(1, static_cast<char>('x' + d))) {
                axisOf[k] = d;
                ++found[static_cast<std::size_t>(d)];
            }
    }
    if (found != std::array<int, 3>{1, 1, 1})
        reader.file.fail("its vertices do not have one property each named x, y and z");
    reader.checkVertexTotal(element.count);
    reader.mesh.vertices.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
        Vec<3> p;
        for (std::size_t k = 0; k < element.properties.size(); ++k) {
            const auto& property = element.properties[k];
            if (axisOf[k] >= 0)
                p[axisOf[k]] = values.real(property.type) + 0.0;
            else
                values.skip(property);
        }
        if (!reader.isUsable(p)) values.fail(fmt::format("vertex {} {}", i, reader.complaint(p)));
        reader.mesh.vertices.push_back(p);
    }
}

void readPlyFaces(MeshReader& reader, PlyValues& values, const PlyElement& element,
                  std::uint64_t vertexCount) {
    const auto isCorners = [](const PlyProperty& property) {
        return property.isList &&
               (property.name == "vertex_indices" || property.name == "vertex_index");
    };
    if (std::count_if(element.properties.begin(), element.properties.end(), isCorners) != 1)
        reader.file.fail("its faces do not have one list named vertex_indices (or vertex_index)");
    for (const auto& property : element.properties)
        if (isCorners(property) && isReal(property.type))
            reader.file.fail("the vertex indices of its faces are not integers");
    reader.mesh.triangles.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i)
        for (const auto& property : element.properties) {
            if (!isCorners(property)) {
                values.skip(property);
                continue;
            }
            const std::uint64_t corners = values.listLength(property);
            if (corners < 3)
                values.fail(
                    fmt::format("face {} has {} corners; 3 or more are needed", i, corners));
            PolygonFan fan;
            for (std::uint64_t k = 0; k < corners; ++k) {
                const std::int64_t index = values.integer(property.type);
                if (index < 0 || static_cast<std::uint64_t>(index) >= vertexCount)
                    values.fail(
                        fmt::format("face {} names vertex {}, but the file has {}, counted from 0",
                                    i, index, vertexCount));
                fan.add(reader, static_cast<std::uint32_t>(index));
            }
            fan.end(reader);
        }
}

}  // namespace

void readPlyMesh(MeshReader& reader) {
    const PlyHeader header = readPlyHeader(reader.file);
    std::uint64_t vertexCount = 0;
    bool hasFaces = false;
    std::vector<std::string> columns;  // of the vertices
    for (const auto& element : header.elements) {
        if (element.name == "vertex") {
            vertexCount = element.count;
            for (const auto& property : element.properties) columns.push_back(property.name);
        }
        if (element.name == "face") hasFaces = element.count > 0;
    }
    if (!hasFaces)
        reader.file.fail(fmt::format(
            "has no faces; a closed surface is needed, not a cloud of points. Spheres need x, y, z "
            "and radius (or r, pscale, radii, scalar_radius, diameter), and the vertices have {}",
            fmt::format("{}", fmt::join(columns, ", ")).substr(0, 200)));
    PlyValues values(reader, header.format);
    for (const auto& element : header.elements) {
        std::uint64_t least = 0;
        for (const auto& property : element.properties)
            least += header.format == PlyFormat::ascii
                         ? 2
                         : bytesOf(property.isList ? property.countType : property.type);
        reader.checkCount(element.count, least, element.name == "face" ? "faces" : "vertices");
        if (element.name == "vertex") {
            readPlyVertices(reader, values, element);
        } else if (element.name == "face") {
            readPlyFaces(reader, values, element, vertexCount);
        } else if (!element.properties.empty()) {
            for (std::uint64_t i = 0; i < element.count; ++i)
                for (const auto& property : element.properties) values.skip(property);
        }
    }
    if (!values.atEnd())
        values.fail("the file continues after what its header announces; its counts are wrong");
}

}  // namespace vdbpack
