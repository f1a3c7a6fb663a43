// Private: what the readers of all mesh formats share.
#pragma once

#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

/// Indices of vertices are below this.
inline constexpr std::uint32_t kMostVertices = std::numeric_limits<std::uint32_t>::max();
/// Sides of triangles are numbered in 32 bits (edge_table.h).
inline constexpr std::size_t kMostTriangles = kMostVertices / 3 - 1;

/// A polygon of more than three corners, as a fan of triangles.
struct PolygonPlace {
    std::size_t firstTriangle;
    std::uint32_t corners;
};

/// Polygons of a file whose outline crosses itself.
struct CrossedFaces {
    std::size_t count = 0;
    Vec<3> firstAt;  ///< first corner of the first of them
};

/// The file, the mesh read from it so far, and the checks of its numbers.
struct MeshReader {
    InputFile& file;
    double largest;  ///< coordinate allowed, in the unit of the file
    CrossedFaces crossed{};
    TriangleMesh mesh{};
    std::vector<PolygonPlace> polygons{};     ///< in rising order
    std::optional<Unit> statedUnit{};         ///< by the file itself
    std::optional<ImageSpace> statedSpace{};  ///< likewise
    MeshGroups groups{};

    /// Whether a point is finite and near enough to the origin.
    bool isUsable(const Vec<3>& p) const {
        return std::fabs(p[0]) <= largest && std::fabs(p[1]) <= largest &&
               std::fabs(p[2]) <= largest;
    }
    /// Why a point is not usable, for a message.
    std::string complaint(const Vec<3>& p) const;
    void checkAtLine(const Vec<3>& p) const {
        if (!isUsable(p)) file.failAtLine("vertex " + complaint(p));
    }
    /// The number that `word` stands for. @throws InputError naming the line and `what`.
    double real(std::string_view word, const char* what) const;
    std::int64_t integer(std::string_view word, const char* what) const;
    /// The three coordinates that come next, checked.
    Vec<3> point(Words& words) const;

    /// Refuses a count that the file is too small for at `least` bytes each.
    void checkCount(std::uint64_t count, std::uint64_t least, const char* what) const;
    /// @throws ResourceError if there are more vertices than indices.
    void checkVertexTotal(std::uint64_t count) const {
        if (count >= kMostVertices) failTotal("vertices", kMostVertices - 1);
    }
    /// The triangles that follow have a name, which may be empty.
    void beginGroup(std::string_view name) {
        groups.emplace_back(trimmed(name), mesh.triangles.size());
    }
    /// @throws ResourceError if there are too many.
    void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (mesh.triangles.size() >= kMostTriangles) failTotal("triangles", kMostTriangles);
        mesh.triangles.push_back({a, b, c});
    }

private:
    [[noreturn]] void failNumber(std::string_view word, const char* what) const;
    [[noreturn]] void failTotal(const char* what, std::size_t most) const;
};

/// Splits a polygon into a fan from its first corner, corner by corner, until all vertices are
/// known (`splitPolygons`).
struct PolygonFan {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::uint64_t corners = 0;
    void add(MeshReader& reader, std::uint32_t corner) {
        if (corners == 0) first = corner;
        if (corners >= 2) reader.addTriangle(first, last, corner);
        last = corner;
        ++corners;
    }
    /// To be called after the last corner.
    void end(MeshReader& reader) const {
        if (corners > 3)
            reader.polygons.push_back({reader.mesh.triangles.size() - (corners - 2),
                                       static_cast<std::uint32_t>(corners)});
    }
};

/// Splits a strip of triangles, each of which shares an edge with the one before, corner by corner.
struct TriangleStrip {
    std::array<std::uint32_t, 2> last{};
    std::uint64_t corners = 0;
    void add(MeshReader& reader, std::uint32_t corner) {
        // Every other triangle runs the other way.
        if (corners >= 2 && corners % 2 == 0) reader.addTriangle(last[0], last[1], corner);
        if (corners >= 2 && corners % 2 == 1) reader.addTriangle(last[1], last[0], corner);
        last = {last[1], corner};
        ++corners;
    }
};

/// Replaces the fans of polygons that are not covered once by them; sets `reader.crossed`.
void splitPolygons(MeshReader& reader);

/// Words of a text file, across its lines.
class TextWords {
public:
    explicit TextWords(InputFile& file) : file_(file) {}
    /// Empty at the end of the file. Valid until the next call.
    std::string_view next() {
        for (;;) {
            const std::string_view word = words_.next();
            if (!word.empty()) return word;
            std::string_view line;
            if (!file_.nextLine(line)) return {};
            words_ = Words(line);
        }
    }
    /// What follows the last word in its line.
    std::string_view rest() const { return words_.rest(); }
    /// Skips the rest of the line.
    void dropLine() { words_ = Words({}); }

private:
    InputFile& file_;
    Words words_{{}};
};

/// Each reads the whole file into `reader.mesh`. Only the reader of STL welds.
/// @throws InputError, ResourceError, IoError
void readStlMesh(MeshReader& reader);
void readObjMesh(MeshReader& reader);
void readOffMesh(MeshReader& reader);
void readGtsMesh(MeshReader& reader);
void readPlyMesh(MeshReader& reader);
void readVtkMesh(MeshReader& reader);
void readVtpMesh(MeshReader& reader);

}  // namespace vdbpack
