// GTS, the GNU Triangulated Surface: vertices, edges of two vertices, triangles of three edges.
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <fmt/format.h>

#include <array>

namespace vdbpack {

namespace {

class GtsMesh {
public:
    explicit GtsMesh(MeshReader& reader) : reader_(reader) {}

    void read() {
        takeLine();
        const auto vertices = count("the number of vertices", 6),
                   edges = count("the number of edges", 4), faces = count("the number of faces", 6);
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next())
            if (endsWith(word, "Binary"))
                reader_.file.failAtLine("binary vertices are not read; save the surface as text");
        reader_.checkVertexTotal(vertices);
        reader_.mesh.vertices.reserve(vertices);
        edges_.reserve(edges);
        for (std::uint64_t i = 0; i < vertices; ++i) {
            takeLine();
            reader_.mesh.vertices.push_back(reader_.point(words_));
        }
        for (std::uint64_t i = 0; i < edges; ++i) {
            takeLine();
            const std::uint32_t from = index("a vertex", vertices);
            edges_.push_back({from, index("a vertex", vertices)});
        }
        for (std::uint64_t i = 0; i < faces; ++i) {
            takeLine();
            addFace();
        }
    }

private:
    using Edge = std::array<std::uint32_t, 2>;

    /// The next line that has something besides a comment.
    void takeLine() {
        std::string_view line;
        do {
            if (!reader_.file.nextLine(line))
                reader_.file.failAtLine(
                    "the file ends before the vertices, edges and faces announced; it is "
                    "truncated");
            statement_ = line.substr(0, line.find_first_of("#!"));
        } while (trimmed(statement_).empty());
        words_ = Words(statement_);
    }

    std::uint64_t count(const char* what, std::uint64_t least) {
        const std::int64_t number = reader_.integer(words_.next(), what);
        if (number < 0) reader_.file.failAtLine(fmt::format("{} is {}, below 0", what, number));
        reader_.checkCount(static_cast<std::uint64_t>(number), least, what);
        return static_cast<std::uint64_t>(number);
    }

    /// The next word as an index from 0 on.
    std::uint32_t index(const char* what, std::uint64_t count) {
        const std::int64_t number = reader_.integer(words_.next(), what);
        if (number < 1 || static_cast<std::uint64_t>(number) > count)
            reader_.file.failAtLine(fmt::format(
                "{} {} is named, but the file has {}, counted from 1", what, number, count));
        return static_cast<std::uint32_t>(number - 1);
    }

    /// The second corner is where the first two edges meet.
    void addFace() {
        std::array<Edge, 3> sides{};
        for (Edge& side : sides) side = edges_[index("an edge", edges_.size())];
        auto& [first, second, third] = sides;
        if (first[1] != second[0] && first[1] != second[1]) std::swap(first[0], first[1]);
        if (first[1] != second[0]) std::swap(second[0], second[1]);
        const Edge closing{second[1], first[0]}, opposite{first[0], second[1]};
        if (first[1] != second[0] || (third != closing && third != opposite))
            reader_.file.failAtLine("the three edges of a face do not meet; export the mesh again");
        reader_.addTriangle(first[0], first[1], second[1]);
    }

    MeshReader& reader_;
    std::string statement_;
    Words words_{{}};
    std::vector<Edge> edges_;
};

}  // namespace

void readGtsMesh(MeshReader& reader) {
    GtsMesh(reader).read();
}

}  // namespace vdbpack
