// Stanford polygon files, text or binary, with faces.
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/ply_header.h"
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <vector>

namespace vdbpack {

namespace {

/// Values of a PLY body, whatever their encoding.
class PlyValues {
public:
    PlyValues(MeshReader& reader, PlyFormat format)
        : reader_(reader),
          words_(reader.file),
          format_(format),
          swap_((format == PlyFormat::bigEndian) != hostIsBigEndian()) {}

    double real(NumberType type) {
        if (format_ == PlyFormat::ascii) return reader_.real(words_.next(), "a number");
        double number = 0;
        takeNumber(type, [&number](auto value) {
            number = static_cast<double>(value);
            return true;
        });
        return number;
    }
    /// @param type  not one of real numbers.
    std::int64_t integer(NumberType type) {
        if (format_ == PlyFormat::ascii) return reader_.integer(words_.next(), "an integer");
        std::int64_t number = 0;
        takeNumber(type, [&number](auto value) {
            number = static_cast<std::int64_t>(value);
            return true;
        });
        return number;
    }
    /// The length of a list, checked against what is left of the file.
    std::uint64_t listLength(const PlyProperty& property) {
        const std::int64_t n = integer(property.countType);
        // A list in text ends with the words that are there.
        if (n < 0 ||
            (format_ != PlyFormat::ascii &&
             static_cast<std::uint64_t>(n) > reader_.file.remaining() / bytesOf(property.type)))
            fail(
                fmt::format("list of {} values, more than the file holds; it is truncated or "
                            "broken",
                            n));
        return static_cast<std::uint64_t>(n);
    }
    void skip(const PlyProperty& property) {
        const std::uint64_t n = property.isList ? listLength(property) : 1;
        for (std::uint64_t i = 0; i < n; ++i) {
            if (format_ == PlyFormat::ascii) {
                if (words_.next().empty()) truncated();
            } else {
                if (reader_.file.take(bytesOf(property.type)) == nullptr) truncated();
            }
        }
    }
    /// Names the current position.
    [[noreturn]] void fail(const std::string& what) const {
        if (format_ == PlyFormat::ascii) reader_.file.failAtLine(what);
        reader_.file.failAtByte(reader_.file.offset(), what);
    }
    /// True if only blanks follow.
    bool atEnd() {
        if (format_ == PlyFormat::ascii) return words_.next().empty();
        while (const char* c = reader_.file.take(1))
            if (std::isspace(static_cast<unsigned char>(*c)) == 0) return false;
        return true;
    }

private:
    template <typename Use>
    void takeNumber(NumberType type, const Use& use) {
        const char* const bytes = reader_.file.take(bytesOf(type));
        if (bytes == nullptr) truncated();
        if (!loadNumber(type, bytes, swap_, use)) fail("a number beyond 64 bits");
    }
    [[noreturn]] void truncated() const { fail("the file ends too early; it is truncated"); }

    MeshReader& reader_;
    TextWords words_;
    PlyFormat format_;
    bool swap_;  ///< the bytes of each number
};

void readPlyVertices(MeshReader& reader, PlyValues& values, const PlyElement& element,
                     bool isBinary) {
    std::vector<int> axisOf(element.properties.size(), -1);
    std::array<int, 3> found{};
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const auto& property = element.properties[k];
        for (int d = 0; d < 3; ++d)
            if (!property.isList && property.name == std::string(1, static_cast<char>('x' + d))) {
                axisOf[k] = d;
                ++found[static_cast<std::size_t>(d)];
                reader.facts.singlePrecision |= isBinary && property.type == NumberType::f32;
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
    constexpr std::array<const char*, 3> kFormats{"ASCII PLY", "binary PLY (little endian)",
                                                  "binary PLY (big endian)"};
    reader.facts.format = kFormats[static_cast<std::size_t>(header.format)];
    std::uint64_t vertexCount = 0;
    bool hasFaces = false;
    for (const auto& element : header.elements) {
        if (element.name == "vertex") vertexCount = element.count;
        if (element.name == "face") hasFaces = element.count > 0;
    }
    if (!hasFaces)
        reader.file.fail("has no faces; a closed surface is needed, not a cloud of points");
    PlyValues values(reader, header.format);
    for (const auto& element : header.elements) {
        std::uint64_t least = 0;
        for (const auto& property : element.properties)
            least += header.format == PlyFormat::ascii
                         ? 2
                         : bytesOf(property.isList ? property.countType : property.type);
        reader.checkCount(element.count, least, element.name == "face" ? "faces" : "vertices");
        if (element.name == "vertex") {
            readPlyVertices(reader, values, element, header.format != PlyFormat::ascii);
        } else if (element.name == "face") {
            readPlyFaces(reader, values, element, vertexCount);
            reader.facts.faces = element.count;
        } else if (!element.properties.empty()) {
            for (std::uint64_t i = 0; i < element.count; ++i)
                for (const auto& property : element.properties) values.skip(property);
        }
    }
    if (!values.atEnd())
        values.fail("the file continues after what its header announces; its counts are wrong");
    reader.facts.vertices = reader.mesh.vertices.size();
}

}  // namespace vdbpack
