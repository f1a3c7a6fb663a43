// OFF as text, with or without colors and normals.
#include "vdbpack/io/numbers.h"
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <fmt/format.h>

namespace vdbpack {

namespace {

/// The next line that has something besides a comment.
bool takeOffLine(InputFile& file, std::string_view& line) {
    while (file.nextLine(line)) {
        line = line.substr(0, line.find('#'));
        if (!Words(line).next().empty()) return true;
    }
    return false;
}

/// Whether `word` is a first word such as OFF, COFF or STNOFF: ST, C and N announce what follows
/// the three coordinates of a vertex, which is not needed.
bool isKeyword(std::string_view word) {
    if (!endsWith(word, "OFF")) return false;
    word.remove_suffix(3);
    for (const std::string_view part : {"ST", "C", "N"})
        if (startsWith(word, part)) word.remove_prefix(part.size());
    return word.empty();
}

struct Counts {
    std::int64_t vertices = 0;
    std::int64_t faces = 0;
};

/// The first lines: the keyword, which may be missing, and the counts.
Counts readCounts(MeshReader& reader) {
    InputFile& file = reader.file;
    std::string_view line;
    if (!takeOffLine(file, line)) file.fail("is empty; an OFF file begins with 'OFF'");
    Words words(line);
    std::string_view word = words.next();
    std::int64_t number = 0;
    if (!parseInteger(word, number)) {
        if (!isKeyword(word))
            file.failAtLine("'OFF', 'COFF', 'NOFF' or 'STOFF' expected, found " +
                            quotedExcerpt(word));
        word = words.next();
        if (equalsNoCase(word, "binary"))
            file.failAtLine("binary OFF is not read; save it as ASCII OFF or as PLY");
        if (word.empty()) {
            if (!takeOffLine(file, line)) file.fail("ends before its counts; it is truncated");
            words = Words(line);
            word = words.next();
        }
    }
    Counts counts;
    counts.vertices = reader.integer(word, "the number of vertices");
    counts.faces = reader.integer(words.next(), "the number of faces");
    if (counts.vertices < 0 || counts.faces < 0)
        file.failAtLine(
            fmt::format("negative count: {} vertices, {} faces", counts.vertices, counts.faces));
    // The shortest lines are "0 0 0" and "3 0 1 2".
    reader.checkCount(static_cast<std::uint64_t>(counts.vertices), 6, "vertices");
    reader.checkCount(static_cast<std::uint64_t>(counts.faces), 8, "faces");
    reader.checkVertexTotal(static_cast<std::uint64_t>(counts.vertices));
    return counts;
}

void readFace(MeshReader& reader, Words words, std::int64_t face, std::int64_t vertexCount) {
    const std::int64_t corners = reader.integer(words.next(), "the number of corners");
    if (corners < 3)
        reader.file.failAtLine(
            fmt::format("face {} has {} corners; 3 or more are needed", face, corners));
    PolygonFan fan;
    for (std::int64_t k = 0; k < corners; ++k) {
        const std::int64_t index = reader.integer(words.next(), "a vertex index");
        if (index < 0 || index >= vertexCount)
            reader.file.failAtLine(
                fmt::format("face {} names vertex {}, but the file has {}, counted from 0", face,
                            index, vertexCount));
        fan.add(reader, static_cast<std::uint32_t>(index));
    }
    fan.end(reader);
}

}  // namespace

void readOffMesh(MeshReader& reader) {
    InputFile& file = reader.file;
    const Counts counts = readCounts(reader);
    auto& vertices = reader.mesh.vertices;
    vertices.reserve(static_cast<std::size_t>(counts.vertices));
    reader.mesh.triangles.reserve(static_cast<std::size_t>(counts.faces));
    std::string_view line;
    const auto takeLine = [&](std::int64_t done, std::int64_t count, const char* what) {
        if (!takeOffLine(file, line))
            file.failAtLine(
                fmt::format("the file ends after {} of {} {}; it is truncated", done, count, what));
        return Words(line);
    };
    for (std::int64_t i = 0; i < counts.vertices; ++i) {
        Words words = takeLine(i, counts.vertices, "vertices");
        vertices.push_back(reader.point(words));
    }
    for (std::int64_t i = 0; i < counts.faces; ++i)
        readFace(reader, takeLine(i, counts.faces, "faces"), i, counts.vertices);
    if (takeOffLine(file, line))
        file.failAtLine(fmt::format(
            "the file continues after the {} vertices and {} faces announced; its counts are wrong",
            counts.vertices, counts.faces));
}

}  // namespace vdbpack
