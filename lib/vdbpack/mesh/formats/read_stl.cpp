// STL, binary or text: triangles without shared vertices, which are welded.
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/stated_unit.h"
#include "vdbpack/mesh/formats/mesh_reader.h"
#include "vdbpack/mesh/welding.h"

#include <fmt/format.h>

#include <array>

namespace vdbpack {

namespace {

constexpr std::uint64_t kStlHeader = 84;
constexpr std::uint64_t kStlTriangle = 50;

void readBinaryStl(MeshReader& reader, Welder& welder) {
    InputFile& file = reader.file;
    const char* const header = file.take(kStlHeader);
    const std::uint64_t count =
        header != nullptr ? loadLittleEndian<std::uint32_t>(header + kStlHeader - 4) : 0;
    if (header == nullptr || kStlHeader + kStlTriangle * count != file.size())
        file.fail(
            fmt::format("is not a complete STL file: {} bytes, where a binary one with the {} "
                        "triangles announced has {}, and an ASCII one begins with 'solid'; it may "
                        "be truncated, export it again",
                        file.size(), count, kStlHeader + kStlTriangle * count));
    reader.statedUnit = statedUnit({header, kStlHeader - 4});
    reader.mesh.triangles.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t offset = file.offset();
        const char* const record = file.take(kStlTriangle);
        if (record == nullptr) file.failAtByte(offset, "the file became shorter while reading");
        std::array<std::uint32_t, 3> corner{};
        for (std::size_t k = 0; k < 3; ++k) {
            Vec<3> p;
            // The normal comes first and is not needed.
            for (int d = 0; d < 3; ++d)
                p[d] = static_cast<double>(loadLittleEndian<float>(
                           record + 12 + 12 * k + 4 * static_cast<std::size_t>(d))) +
                       0.0;
            if (!reader.isUsable(p))
                file.failAtByte(offset + 12 + 12 * k, fmt::format("vertex {} of triangle {} {}", k,
                                                                  i, reader.complaint(p)));
            corner[k] = welder.add(p);
        }
        reader.addTriangle(corner[0], corner[1], corner[2]);
    }
}

void readAsciiStl(MeshReader& reader, Welder& welder) {
    InputFile& file = reader.file;
    TextWords words(file);
    const auto expect = [&](std::string_view keyword) {
        const auto word = words.next();
        if (equalsNoCase(word, keyword)) return;
        if (word.empty())
            file.failAtLine(fmt::format(
                "the file ends where '{}' is expected; it is truncated, export it again", keyword));
        file.failAtLine(fmt::format("'{}' expected, found {}", keyword, quotedExcerpt(word)));
    };
    expect("solid");
    reader.beginGroup(words.rest());
    words.dropLine();
    for (bool inSolid = true;;) {
        const auto word = words.next();
        if (word.empty()) {
            if (inSolid) file.failAtLine("the file ends before 'endsolid'; it is truncated");
            return;
        }
        if (!inSolid) {
            if (!equalsNoCase(word, "solid"))
                file.failAtLine("'solid' expected, found " + quotedExcerpt(word));
            reader.beginGroup(words.rest());
            words.dropLine();
            inSolid = true;
        } else if (equalsNoCase(word, "endsolid")) {
            words.dropLine();
            inSolid = false;
        } else if (equalsNoCase(word, "facet")) {
            // The normal may be anything, nan included: it is not needed.
            expect("normal");
            for (int i = 0; i < 3; ++i) words.next();
            expect("outer");
            expect("loop");
            std::array<std::uint32_t, 3> corner{};
            for (auto& c : corner) {
                expect("vertex");
                Vec<3> p;
                for (int d = 0; d < 3; ++d) p[d] = reader.real(words.next(), "a coordinate") + 0.0;
                reader.checkAtLine(p);
                c = welder.add(p);
            }
            expect("endloop");
            expect("endfacet");
            reader.addTriangle(corner[0], corner[1], corner[2]);
            reader.checkVertexTotal(welder.size());
        } else {
            file.failAtLine("'facet' or 'endsolid' expected, found " + quotedExcerpt(word));
        }
    }
}

/// Whether the file begins with "solid" and does not have exactly the length of a binary file with
/// its triangle count: programs write binary files whose header begins with "solid".
bool isAsciiStl(InputFile& file) {
    const std::string_view head = file.peek(1024);
    if (head.size() >= kStlHeader &&
        kStlHeader + kStlTriangle * loadLittleEndian<std::uint32_t>(head.data() + kStlHeader - 4) ==
            file.size())
        return false;
    if (head.find('\0') != std::string_view::npos) return false;
    const std::size_t begin = head.find_first_not_of(" \t\r\n");
    return begin != std::string_view::npos && equalsNoCase(head.substr(begin, 5), "solid");
}

}  // namespace

void readStlMesh(MeshReader& reader) {
    const bool isText = isAsciiStl(reader.file);
    // A closed surface has half as many vertices as triangles.
    Welder welder(isText ? 0 : reader.file.size() / kStlTriangle / 2);
    if (isText)
        readAsciiStl(reader, welder);
    else
        readBinaryStl(reader, welder);
    reader.mesh.vertices = welder.takeVertices();
}

}  // namespace vdbpack
