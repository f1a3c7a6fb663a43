// VTK's XML polygon data (.vtp) with polygons: OpenSim's bones, surfaces from ParaView.
#include "vdbpack/io/vtk_xml.h"
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <fmt/format.h>

#include <cstdint>

namespace vdbpack {

namespace {

class VtpMesh {
public:
    explicit VtpMesh(MeshReader& reader)
        : reader_(reader), xml_(reader.file.path(), "PolyData", 0) {}

    void read() {
        readSpace();
        for (const pugi::xml_node& piece : xml_.data().children("Piece")) {
            first_ = reader_.mesh.vertices.size();
            readPoints(piece);
            readFaces(piece, "Polys", "NumberOfPolys");
            readFaces(piece, "Strips", "NumberOfStrips");
        }
        if (reader_.mesh.triangles.empty())
            xml_.fail("holds points without polygons; a closed surface is needed");
    }

private:
    /// The axes of the coordinates, which 3D Slicer writes as field data.
    void readSpace() {
        for (const pugi::xml_node& node : xml_.data().child("FieldData")) {
            if (!VtkXml::isArray(node) || VtkXml::attribute(node, "Name") != "SPACE" ||
                VtkXml::attribute(node, "type") != "String")
                continue;
            const std::string space = xml_.arrays().texts(xml_.described(node), 1, 16)[0];
            if (space == "RAS") reader_.statedSpace = ImageSpace::ras;
            if (space == "LPS") reader_.statedSpace = ImageSpace::lps;
        }
    }

    /// The array of that name in a section of a piece; of any name for an empty one.
    VtkArray arrayOf(const pugi::xml_node& section, const char* name) const {
        for (const pugi::xml_node& node : section)
            if (VtkXml::isArray(node) && (*name == 0 || VtkXml::attribute(node, "Name") == name))
                return xml_.described(node);
        xml_.fail(fmt::format("a piece has no array {} in its {}", name, section.name()));
    }

    void readPoints(const pugi::xml_node& piece) {
        const std::uint64_t count = xml_.countOf(piece, "NumberOfPoints");
        if (count == 0) return;
        const VtkArray array = arrayOf(piece.child("Points"), "");
        if (array.components != 3 || array.string)
            xml_.fail("a piece has no points with three coordinates");
        reader_.checkVertexTotal(first_ + count);
        const VtkNumbers numbers = xml_.arrays().numbers(array, count);
        reader_.mesh.vertices.reserve(first_ + count);
        for (std::uint64_t i = 0; i < count; ++i) {
            Vec<3> p;
            for (int d = 0; d < 3; ++d)
                numbers.at(3 * i + static_cast<std::uint64_t>(d), [&](auto value) {
                    p[d] = static_cast<double>(value) + 0.0;
                    return true;
                });
            if (!reader_.isUsable(p))
                xml_.fail(fmt::format("point {} {}", first_ + i, reader_.complaint(p)));
            reader_.mesh.vertices.push_back(p);
        }
    }

    VtkNumbers indicesOf(const pugi::xml_node& section, const char* name, std::uint64_t count) {
        const VtkArray array = arrayOf(section, name);
        if (array.components != 1 || array.string || isReal(array.type))
            xml_.fail(fmt::format("array {} of its {} does not hold one whole number each", name,
                                  section.name()));
        return xml_.arrays().numbers(array, count);
    }
    static std::int64_t at(const VtkNumbers& numbers, std::uint64_t i) {
        std::int64_t number = -1;
        numbers.at(i, [&](auto value) {
            number = static_cast<std::int64_t>(value);
            return true;
        });
        return number;
    }

    void readFaces(const pugi::xml_node& piece, const char* name, const char* countName) {
        const std::uint64_t count = piece.attribute(countName) ? xml_.countOf(piece, countName) : 0;
        if (count == 0) return;
        const pugi::xml_node section = piece.child(name);
        const VtkNumbers ends = indicesOf(section, "offsets", count);
        const std::int64_t last = at(ends, count - 1);
        if (last < 0) xml_.fail(fmt::format("the {} end at {}, below 0", name, last));
        const VtkNumbers corners =
            indicesOf(section, "connectivity", static_cast<std::uint64_t>(last));
        std::int64_t begin = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::int64_t end = at(ends, i);
            if (end - begin < 3 || end > last)
                xml_.fail(
                    fmt::format("face {} of its {} runs from entry {} to {} of {}; 3 corners "
                                "or more are needed",
                                i, name, begin, end, last));
            addFace(corners, begin, end, *name == 'S', i);
            begin = end;
        }
    }

    void addFace(const VtkNumbers& corners, std::int64_t begin, std::int64_t end, bool strip,
                 std::uint64_t number) {
        PolygonFan fan;
        TriangleStrip triangles;
        for (std::int64_t k = begin; k < end; ++k) {
            const std::int64_t index = at(corners, static_cast<std::uint64_t>(k));
            const std::size_t points = reader_.mesh.vertices.size() - first_;
            if (index < 0 || static_cast<std::uint64_t>(index) >= points)
                xml_.fail(
                    fmt::format("face {} names point {}, but its piece has {}, counted from 0",
                                number, index, points));
            const auto vertex =
                static_cast<std::uint32_t>(first_ + static_cast<std::uint64_t>(index));
            if (strip)
                triangles.add(reader_, vertex);
            else
                fan.add(reader_, vertex);
        }
        fan.end(reader_);
    }

    MeshReader& reader_;
    VtkXml xml_;
    std::size_t first_ = 0;  ///< vertex of the piece
};

}  // namespace

void readVtpMesh(MeshReader& reader) {
    VtpMesh(reader).read();
}

}  // namespace vdbpack
