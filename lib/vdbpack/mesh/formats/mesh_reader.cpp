#include "vdbpack/mesh/formats/mesh_reader.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/mesh/polygon.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace vdbpack {

std::string MeshReader::complaint(const Vec<3>& p) const {
    if (!isFinite(p))
        return fmt::format("is not finite: ({}, {}, {}); export the mesh again", p[0], p[1], p[2]);
    return fmt::format("lies more than 1e9 mm from the origin: ({}, {}, {}); check the unit", p[0],
                       p[1], p[2]);
}

double MeshReader::real(std::string_view word, const char* what) const {
    double value = 0;
    if (!parseReal(word, value)) failNumber(word, what);
    return value;
}

std::int64_t MeshReader::integer(std::string_view word, const char* what) const {
    std::int64_t value = 0;
    if (!parseInteger(word, value)) failNumber(word, what);
    return value;
}

Vec<3> MeshReader::point(Words& words) const {
    Vec<3> p;
    for (int d = 0; d < 3; ++d) p[d] = real(words.next(), "a coordinate") + 0.0;  // -0 becomes 0
    checkAtLine(p);
    return p;
}

void MeshReader::checkCount(std::uint64_t count, std::uint64_t least, const char* what) const {
    if (least > 0 && count > (file.size() + 1) / least)
        file.fail(
            fmt::format("{} {} are announced, too many for a file of {} bytes; it is truncated or "
                        "its header is wrong",
                        count, what, file.size()));
}

void MeshReader::failNumber(std::string_view word, const char* what) const {
    if (word.empty())
        file.failAtLine(std::string(what) +
                        " expected, but nothing is left; the file may be truncated");
    file.failAtLine(std::string(what) + " expected, found " + quotedExcerpt(word));
}

void MeshReader::failTotal(const char* what, std::size_t most) const {
    throw ResourceError(
        fmt::format("{}: more than {} {}; simplify the mesh", file.path(), most, what));
}

void splitPolygons(MeshReader& reader) {
    const auto& polygons = reader.polygons;
    auto& mesh = reader.mesh;
    std::vector<char> isCrossed(polygons.size(), 0);
    forAll(polygons.size(), [&](std::size_t i) {
        const auto triangle =
            mesh.triangles.begin() + static_cast<std::ptrdiff_t>(polygons[i].firstTriangle);
        std::vector<std::uint32_t> vertices{(*triangle)[0], (*triangle)[1]};
        for (std::uint32_t k = 0; k + 2 < polygons[i].corners; ++k)
            vertices.push_back(triangle[k][2]);
        std::vector<Vec<3>> corners;
        corners.reserve(vertices.size());
        for (const std::uint32_t v : vertices) corners.push_back(mesh.vertices[v]);
        std::vector<std::array<std::uint32_t, 3>> parts;
        const PolygonSplit split = splitPolygon(corners, parts);
        isCrossed[i] = static_cast<char>(split == PolygonSplit::crossed);
        if (split != PolygonSplit::ears) return;
        std::transform(parts.begin(), parts.end(), triangle, [&](const auto& t) {
            return std::array<std::uint32_t, 3>{vertices[t[0]], vertices[t[1]], vertices[t[2]]};
        });
    });
    const auto first = std::find(isCrossed.begin(), isCrossed.end(), char{1});
    if (first == isCrossed.end()) return;
    reader.crossed.count = static_cast<std::size_t>(std::count(first, isCrossed.end(), char{1}));
    const auto& polygon = polygons[static_cast<std::size_t>(first - isCrossed.begin())];
    reader.crossed.firstAt = mesh.vertices[mesh.triangles[polygon.firstTriangle][0]];
}

}  // namespace vdbpack
