#include "vdbpack/mesh/mesh_check.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/mesh/edge_table.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/shell_intersections.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace vdbpack {

namespace {

/// A triangle whose height is below this share of its longest side has no area, except by rounding.
constexpr double kFlat = 1e-9;
/// A shell with a smaller share of the largest one's volume faces neither way.
constexpr double kNoVolume = 1e-12;

std::string text(const Vec<3>& p) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", p[0], p[1], p[2]);
}

std::string plural(std::size_t n, const char* one) {
    return fmt::format("{} {}{}", n, one, n == 1 ? "" : "s");
}

/// [i] is the first triangle with the same three vertices as triangle i. Rows by the lowest vertex:
/// linear time for any mesh but a fan of very many triangles.
std::vector<std::uint32_t> findFirst(const TriangleMesh& mesh) {
    struct Entry {
        std::uint32_t middle;
        std::uint32_t upper;
        std::uint32_t triangle;
    };
    const auto sorted = [](std::array<std::uint32_t, 3> t) {
        std::sort(t.begin(), t.end());
        return t;
    };
    std::vector<std::size_t> rows(mesh.vertices.size() + 1, 0);
    for (const auto& t : mesh.triangles) ++rows[*std::min_element(t.begin(), t.end()) + 1];
    std::partial_sum(rows.begin(), rows.end(), rows.begin());
    std::vector<Entry> entries(mesh.triangles.size());
    {
        auto next = rows;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto t = sorted(mesh.triangles[i]);
            entries[next[t[0]]++] = {t[1], t[2], static_cast<std::uint32_t>(i)};
        }
    }
    std::vector<std::uint32_t> firstOf(mesh.triangles.size());
    std::iota(firstOf.begin(), firstOf.end(), 0u);
    for (std::size_t v = 0; v + 1 < rows.size(); ++v) {
        const auto first = entries.begin() + static_cast<std::ptrdiff_t>(rows[v]);
        const auto last = entries.begin() + static_cast<std::ptrdiff_t>(rows[v + 1]);
        std::sort(first, last, [](const Entry& a, const Entry& b) {
            if (a.middle != b.middle) return a.middle < b.middle;
            return a.upper != b.upper ? a.upper < b.upper : a.triangle < b.triangle;
        });
        for (auto e = first; e != last && e + 1 != last; ++e)
            if (e->middle == (e + 1)->middle && e->upper == (e + 1)->upper)
                firstOf[(e + 1)->triangle] = firstOf[e->triangle];
    }
    return firstOf;
}

/// Groups boundary edges by the vertices they share and measures the longest group.
MeshLeak measureLeak(const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint32_t, 2>>& boundary) {
    const auto group = groupEdges(boundary);
    std::vector<BoundaryLoop> loops(*std::max_element(group.begin(), group.end()) + std::size_t{1});
    for (std::size_t i = 0; i < boundary.size(); ++i) {
        const Vec<3>& a = mesh.vertices[boundary[i][0]];
        const Vec<3>& b = mesh.vertices[boundary[i][1]];
        auto& loop = loops[group[i]];
        const double l = length(b - a);
        ++loop.edges;
        loop.length += l;
        loop.center += (a + b) * (0.5 * l);
    }
    MeshLeak leak;
    leak.vertex = boundary.front()[0];  // edges come by rising lower vertex
    leak.position = mesh.vertices[leak.vertex];
    leak.loops = loops.size();
    leak.largest = *std::max_element(
        loops.begin(), loops.end(),
        [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.length < b.length; });
    leak.largest.center =
        leak.largest.length > 0 ? leak.largest.center * (1.0 / leak.largest.length) : leak.position;
    return leak;
}

nlohmann::json json(const Vec<3>& p) {
    return {p[0], p[1], p[2]};
}

/// Groups of triangles that are connected by vertices.
std::size_t countPieces(const TriangleMesh& mesh) {
    DisjointSets sets(mesh.vertices.size());
    std::vector<char> isUsed(mesh.vertices.size(), 0);
    for (const auto& t : mesh.triangles)
        for (const auto v : t) {
            isUsed[v] = 1;
            sets.join(t[0], v);
        }
    std::size_t pieces = 0;
    for (std::uint32_t v = 0; v < isUsed.size(); ++v) pieces += isUsed[v] != 0 && sets.find(v) == v;
    return pieces;
}

/// Sets vertices, bounds, area and degenerate triangles. @return collapsed triangles.
std::size_t measureTriangles(const TriangleMesh& mesh, MeshHealth& health) {
    health.triangles = mesh.triangles.size();
    std::vector<char> isUsed(mesh.vertices.size(), 0);
    std::size_t collapsed = 0;
    for (const auto& t : mesh.triangles) {
        for (const auto v : t) isUsed[v] = 1;
        if (isCollapsed(t)) {
            ++collapsed;
            ++health.degenerateTriangles;
            continue;
        }
        const Vec<3> ab = mesh.vertices[t[1]] - mesh.vertices[t[0]];
        const Vec<3> ac = mesh.vertices[t[2]] - mesh.vertices[t[0]];
        const double twice = length(cross(ab, ac));
        const double longest =
            std::max({squaredLength(ab), squaredLength(ac), squaredLength(ac - ab)});
        health.area += 0.5 * twice;
        // Height = twice the area divided by the longest side.
        if (!(twice > kFlat * longest)) ++health.degenerateTriangles;
    }
    for (std::size_t v = 0; v < isUsed.size(); ++v)
        if (isUsed[v] != 0) {
            ++health.vertices;
            health.bounds.add(mesh.vertices[v]);
        }
    return collapsed;
}

/// Counts the edges of each kind and measures the leak.
void countEdges(const TriangleMesh& mesh, const EdgeTable& edges, MeshHealth& health) {
    std::vector<std::array<std::uint32_t, 2>> boundary;
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        ++health.edges;
        const auto uses = last - first;
        if (uses == 1) boundary.push_back({lower, upper});
        if (uses == 2 && edges.isForward(first[0]) == edges.isForward(first[1]))
            ++health.inconsistentEdges;
        if (uses > 2) ++health.nonManifoldEdges;
        if (uses > 2 && edges.surplus(first, last) != 0) ++health.unbalancedEdges;
    });
    health.boundaryEdges = boundary.size();
    if (!boundary.empty()) health.leak = measureLeak(mesh, boundary);
}

void countShells(const ShellAnalysis& analysis, MeshHealth& health) {
    health.shells = analysis.shells.size();
    health.enclosedVolume = analysis.enclosedVolume();
    // Shells whose triangles cancel have a volume by rounding alone.
    const double least =
        analysis.shells.empty() ? 0 : kNoVolume * std::fabs(analysis.shells.front().signedVolume);
    for (const auto& shell : analysis.shells) {
        health.signedVolume += shell.signedVolume;
        const auto depth = static_cast<std::size_t>(shell.depth);
        if (health.shellsAtDepth.size() <= depth) health.shellsAtDepth.resize(depth + 1);
        ++health.shellsAtDepth[depth];
        if (shell.boundaryEdges == 0 && std::fabs(shell.signedVolume) > least &&
            (shell.signedVolume > 0) != (shell.depth % 2 == 0))
            ++health.invertedShells;
    }
}

}  // namespace

std::string MeshHealth::describeLeak() const {
    if (!leak) return {};
    return fmt::format("{}, first at vertex {} {}; largest hole: {}, {:.4g} mm around, at {}",
                       plural(boundaryEdges, "boundary edge"), leak->vertex, text(leak->position),
                       plural(leak->largest.edges, "edge"), leak->largest.length,
                       text(leak->largest.center));
}

std::string MeshHealth::describeIntersections() const {
    // Without the digits that points of a sample do not have.
    const double step = std::pow(10, std::floor(std::log10(1e-2 * length(bounds.size()))));
    Vec<3> at;
    for (int d = 0; d < 3; ++d) at[d] = std::round(intersectionAt[d] / step) * step + 0.0;
    return fmt::format("{} of components that intersect, in about {:.3g} mm³ around {}",
                       plural(intersections, "pair"), intersectionVolume, text(at));
}

MeshAnalysis analyzeMesh(const TriangleMesh& mesh, bool isContour) {
    MeshAnalysis analysis;
    MeshHealth& health = analysis.health;
    std::size_t collapsed = 0;
    // Each sets members of its own.
    invokeAll(
        [&] {
            const EdgeTable edges(mesh);
            countEdges(mesh, edges, health);
            analysis.shells = analyzeShells(mesh, edges);
            countShells(analysis.shells, health);
            if (isContour) return;
            const ShellIntersections found = findIntersections(mesh, analysis.shells);
            health.intersections = found.pairs;
            health.intersectionVolume = found.volume;
            health.intersectionAt = found.at;
        },
        [&] { collapsed = measureTriangles(mesh, health); },
        [&] {
            const auto firstOf = findFirst(mesh);
            for (std::uint32_t i = 0; i < firstOf.size(); ++i)
                health.duplicateTriangles += firstOf[i] != i;
        },
        [&] { health.pieces = countPieces(mesh); });
    health.eulerNumber = static_cast<std::int64_t>(health.vertices) -
                         static_cast<std::int64_t>(health.edges) +
                         static_cast<std::int64_t>(health.triangles - collapsed);
    return analysis;
}

MeshHealth checkMesh(const TriangleMesh& mesh) {
    return analyzeMesh(mesh).health;
}

TriangleMesh withoutDuplicates(const TriangleMesh& mesh, bool withCommonWalls) {
    const auto firstOf = findFirst(mesh);
    // How many of the copies of a triangle face as the first does, less those that face the other
    // way.
    std::vector<int> surplus(withCommonWalls ? 0 : mesh.triangles.size());
    for (std::size_t i = 0; i < surplus.size(); ++i) {
        const auto& t = mesh.triangles[i];
        const auto& first = mesh.triangles[firstOf[i]];
        const auto at =
            static_cast<std::size_t>(std::find(t.begin(), t.end(), first[0]) - t.begin());
        surplus[firstOf[i]] += t[(at + 1) % 3] == first[1] ? 1 : -1;
    }
    TriangleMesh clean;
    clean.vertices = mesh.vertices;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
        if (firstOf[i] == i && !isCollapsed(mesh.triangles[i]) &&
            (withCommonWalls || surplus[i] != 0))
            clean.triangles.push_back(mesh.triangles[i]);
    return clean;
}

nlohmann::json toJson(const MeshHealth& health) {
    nlohmann::json leak = nullptr;
    if (health.leak)
        leak = {{"vertex", health.leak->vertex},
                {"position", json(health.leak->position)},
                {"loops", health.leak->loops},
                {"largest",
                 {{"edges", health.leak->largest.edges},
                  {"length", health.leak->largest.length},
                  {"center", json(health.leak->largest.center)}}}};
    nlohmann::json bounds = nullptr;
    if (!health.bounds.empty())
        bounds = {{"min", json(health.bounds.lo)}, {"max", json(health.bounds.hi)}};
    return {{"triangles", health.triangles},
            {"vertices", health.vertices},
            {"edges", health.edges},
            {"pieces", health.pieces},
            {"shells", health.shells},
            {"boundaryEdges", health.boundaryEdges},
            {"nonManifoldEdges", health.nonManifoldEdges},
            {"unbalancedEdges", health.unbalancedEdges},
            {"inconsistentEdges", health.inconsistentEdges},
            {"duplicateTriangles", health.duplicateTriangles},
            {"degenerateTriangles", health.degenerateTriangles},
            {"eulerNumber", health.eulerNumber},
            {"bounds", bounds},
            {"area", health.area},
            {"signedVolume", health.signedVolume},
            {"enclosedVolume", health.enclosedVolume},
            {"shellsAtDepth", health.shellsAtDepth},
            {"invertedShells", health.invertedShells},
            {"intersections", health.intersections},
            {"intersectionVolume", health.intersectionVolume},
            {"closed", health.isClosed()},
            {"watertight", health.isWatertight()},
            {"leak", leak}};
}

std::string toText(const MeshHealth& health) {
    std::string out;
    const auto row = [&](const char* name, const std::string& value) {
        out += fmt::format("{:<22}{}\n", name, value);
    };
    row("triangles", fmt::format("{}", health.triangles));
    row("vertices", fmt::format("{}", health.vertices));
    row("components", fmt::format("{} connected by vertices, {} connected by edges", health.pieces,
                                  health.shells));
    row("boundary edges", fmt::format("{}", health.boundaryEdges));
    row("non-manifold edges", fmt::format("{}", health.nonManifoldEdges));
    row("inconsistent edges", fmt::format("{}", health.inconsistentEdges));
    row("duplicate triangles", fmt::format("{}", health.duplicateTriangles));
    row("degenerate triangles", fmt::format("{}", health.degenerateTriangles));
    row("Euler number", fmt::format("{}", health.eulerNumber));
    if (!health.bounds.empty()) {
        const Vec<3> size = health.bounds.size();
        row("bounds", fmt::format("{} .. {} mm", text(health.bounds.lo), text(health.bounds.hi)));
        row("size", fmt::format("{:.6g} x {:.6g} x {:.6g} mm", size[0], size[1], size[2]));
    }
    row("area", fmt::format("{:.6g} mm²", health.area));
    row("signed volume", fmt::format("{:.6g} mm³", health.signedVolume));
    row("enclosed volume", fmt::format("{:.6g} mm³", health.enclosedVolume));
    for (std::size_t d = 0; d < health.shellsAtDepth.size(); ++d)
        row(d == 0 ? "nesting" : "",
            d == 0 ? fmt::format("{} outside all others", health.shellsAtDepth[d])
                   : fmt::format("{} inside {} ({})", health.shellsAtDepth[d], plural(d, "other"),
                                 d % 2 == 1 ? "bounding a cavity" : "solid in a cavity"));
    if (health.invertedShells > 0)
        row("inverted components", fmt::format("{}", health.invertedShells));
    if (health.intersections > 0) row("intersections", health.describeIntersections());
    if (health.isClosed() && health.enclosesNothing())
        row("verdict", "closed, but encloses no volume");
    else if (health.isWatertight() && health.inconsistentEdges > 0)
        row("verdict", fmt::format("watertight, but triangles face opposite ways at {}",
                                   plural(health.inconsistentEdges, "edge")));
    else if (health.isWatertight())
        row("verdict", "watertight");
    else if (health.isClosed())
        row("verdict", "closed, but has edges with more than two triangles");
    else
        row("verdict", "open: " + health.describeLeak());
    return out;
}

}  // namespace vdbpack
