// Wavefront OBJ: the vertices and faces of all its objects.
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <fmt/format.h>

#include <cctype>

namespace vdbpack {

namespace {

/// Takes a line, and appends the next one while there is a backslash at its end.
bool takeObjLine(InputFile& file, std::string_view& line, std::string& joined) {
    if (!file.nextLine(line)) return false;
    if (line.empty() || line.back() != '\\') return true;
    joined.clear();
    while (!line.empty() && line.back() == '\\') {
        joined.append(line.substr(0, line.size() - 1)).push_back(' ');
        if (!file.nextLine(line)) line = {};
    }
    joined.append(line);
    line = joined;
    return true;
}

/// Index of the vertex of a face's corner, counted from 1.
std::int64_t vertexOf(const MeshReader& reader, std::string_view corner) {
    const InputFile& file = reader.file;
    // Vertex, texture and normal: v, v/t, v//n or v/t/n. Only v is needed.
    const std::size_t slash = corner.find('/');
    if (slash != std::string_view::npos &&
        corner.find_first_not_of("0123456789-+/", slash) != std::string_view::npos)
        file.failAtLine("a corner of a face expected, found " + quotedExcerpt(corner));
    const std::int64_t index = reader.integer(corner.substr(0, slash), "a vertex index");
    if (index == 0) file.failAtLine("face names vertex 0; OBJ counts from 1");
    if (index >= static_cast<std::int64_t>(kMostVertices))
        file.failAtLine(fmt::format(
            "face names vertex {}, out of range: at most {} vertices are read; export it again",
            index, kMostVertices - 1));
    if (index > 0) return index;
    const auto count = static_cast<std::int64_t>(reader.mesh.vertices.size());
    if (index < -count)
        file.failAtLine(
            fmt::format("face names vertex {} counted back, but only {} precede it", index, count));
    return index + count + 1;
}

/// The largest index of a vertex so far: a face may precede its vertices, so that it is checked at
/// the end.
struct LargestIndex {
    std::int64_t index = 0;
    std::uint64_t line = 0;
};

void readFace(MeshReader& reader, Words& words, LargestIndex& largest) {
    PolygonFan fan;
    for (auto word = words.next(); !word.empty(); word = words.next()) {
        const std::int64_t index = vertexOf(reader, word);
        if (index > largest.index) largest = {index, reader.file.lineNumber()};
        fan.add(reader, static_cast<std::uint32_t>(index - 1));
    }
    if (fan.corners < 3)
        reader.file.failAtLine(fmt::format(
            "face with {} corners; 3 or more are needed, the file may be truncated", fan.corners));
    fan.end(reader);
}

}  // namespace

void readObjMesh(MeshReader& reader) {
    InputFile& file = reader.file;
    auto& vertices = reader.mesh.vertices;
    LargestIndex largest;
    std::string_view line;
    std::string joined;
    while (takeObjLine(file, line, joined)) {
        Words words(line);
        const std::string_view keyword = words.next();
        if (keyword == "v") {
            const Vec<3> p = reader.point(words);
            reader.checkVertexTotal(vertices.size());
            vertices.push_back(p);
        } else if (keyword == "g" || keyword == "o") {
            reader.beginGroup(words.rest());
        } else if (keyword == "f") {
            readFace(reader, words, largest);
        } else if (!keyword.empty() && keyword.front() != '#' &&
                   std::isalpha(static_cast<unsigned char>(keyword.front())) == 0) {
            file.failAtLine("is not an OBJ statement: " + quotedExcerpt(keyword));
        }
    }
    if (largest.index > static_cast<std::int64_t>(vertices.size()))
        file.fail(
            fmt::format("line {}: face names vertex {}, but the file has {}; it may be truncated",
                        largest.line, largest.index, vertices.size()));
}

}  // namespace vdbpack
