#include "vdbpack/mesh/mesh_shells.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/mesh/edge_sheets.h"
#include "vdbpack/mesh/edge_table.h"
#include "vdbpack/mesh/vertical_line.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// Triangles of a piece that vote on what encloses it: one or two of them may touch another piece.
constexpr std::size_t kVotes = 5;
/// A piece is enclosed if more than this share of its probes is: others overlap.
constexpr double kEnclosed = 0.75;

/// A point for which the enclosing pieces are determined.
struct Probe {
    Vec<3> p;
    std::uint32_t shell;
};

/// Probes in square cells of the xy plane.
class ProbeGrid {
public:
    explicit ProbeGrid(std::vector<Probe> probes) : probes_(std::move(probes)) {
        for (const auto& probe : probes_) bounds_.add({{probe.p[0], probe.p[1]}});
        const double extent = std::max(bounds_.size()[0], bounds_.size()[1]);
        const double side = std::ceil(std::sqrt(static_cast<double>(probes_.size())));
        cells_ = static_cast<int>(std::clamp(side, 1.0, 1024.0));
        perLength_ = extent > 0 ? cells_ / extent : 0.0;
        first_.assign(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_) + 1, 0);
        for (const auto& probe : probes_) ++first_[cellOf(probe.p) + 1];
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        auto next = first_;
        order_.resize(probes_.size());
        for (std::uint32_t i = 0; i < probes_.size(); ++i) order_[next[cellOf(probes_[i].p)]++] = i;
    }

    /// Calls `f(index, probe)` for every probe in the cells that a rectangle of the xy plane meets.
    template <typename F>
    void visit(double x0, double x1, double y0, double y1, F&& f) const {
        if (x1 < bounds_.lo[0] || x0 > bounds_.hi[0] || y1 < bounds_.lo[1] || y0 > bounds_.hi[1])
            return;
        const int i0 = index(x0, 0);
        const int i1 = index(x1, 0);
        const int j0 = index(y0, 1);
        const int j1 = index(y1, 1);
        for (int j = j0; j <= j1; ++j)
            for (std::size_t k = first_[cell(i0, j)]; k < first_[cell(i1, j) + 1]; ++k)
                f(order_[k], probes_[order_[k]]);
    }

private:
    int index(double x, int axis) const {
        return static_cast<int>(
            std::clamp((x - bounds_.lo[axis]) * perLength_, 0.0, static_cast<double>(cells_ - 1)));
    }
    std::size_t cell(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(cells_) +
               static_cast<std::size_t>(i);
    }
    std::size_t cellOf(const Vec<3>& p) const { return cell(index(p[0], 0), index(p[1], 1)); }

    std::vector<Probe> probes_;
    Box<2> bounds_;
    int cells_ = 1;
    double perLength_ = 0;
    std::vector<std::size_t> first_;
    std::vector<std::uint32_t> order_;
};

/// A ray from a probe met a triangle of a piece.
struct Hit {
    std::uint32_t probe;
    std::uint32_t shell;  ///< of the triangle
    bool unclear;
};

/// The probes of all pieces: the centers of up to `kVotes` of their triangles, evenly spread over
/// the order of the file. Centers, as corners may be shared with the piece that is tested.
std::vector<Probe> probesOf(const TriangleMesh& mesh, const ShellAnalysis& analysis) {
    const auto& shells = analysis.shells;
    std::vector<Probe> probes;
    std::vector<std::size_t> probeCount(shells.size(), 0);
    std::vector<std::size_t> seen(shells.size(), 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::uint32_t s = analysis.shellOfTriangle[i];
        const std::size_t rank = seen[s]++;
        // The triangles with rank = floor(k n / kVotes) vote, k = 0, 1, ...
        const std::size_t votes = std::min(kVotes, shells[s].triangles);
        if (probeCount[s] == votes || rank != probeCount[s] * shells[s].triangles / votes) continue;
        ++probeCount[s];
        const auto& t = mesh.triangles[i];
        const Vec<3>& a = mesh.vertices[t[0]];
        const Vec<3> toCenter =
            ((mesh.vertices[t[1]] - a) + (mesh.vertices[t[2]] - a)) * (1.0 / 3.0);
        probes.push_back({a + toCenter, s});
    }
    return probes;
}

/// The triangles of closed pieces that the upward ray of a probe of another piece meets, in the
/// order of the probe's piece, the triangle's piece, the probe.
std::vector<Hit> findHits(const TriangleMesh& mesh, const ShellAnalysis& analysis,
                          const std::vector<Probe>& probes) {
    const ProbeGrid grid(probes);
    std::vector<Hit> hits;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::uint32_t s = analysis.shellOfTriangle[i];
        const auto& t = mesh.triangles[i];
        if (analysis.shells[s].boundaryEdges != 0 || isCollapsed(t)) continue;
        const Vec<3>& a = mesh.vertices[t[0]];
        const Vec<3>& b = mesh.vertices[t[1]];
        const Vec<3>& c = mesh.vertices[t[2]];
        const double top = std::max({a[2], b[2], c[2]});
        grid.visit(std::min({a[0], b[0], c[0]}), std::max({a[0], b[0], c[0]}),
                   std::min({a[1], b[1], c[1]}), std::max({a[1], b[1], c[1]}),
                   [&](std::uint32_t index, const Probe& probe) {
                       if (probe.shell == s || top < probe.p[2] || !coversLine(mesh, t, probe.p))
                           return;
                       const Height height = heightOver(mesh, t, probe.p);
                       if (height != Height::below)
                           hits.push_back({index, s, height == Height::unclear});
                   });
    }
    std::sort(hits.begin(), hits.end(), [&](const Hit& a, const Hit& b) {
        const std::uint32_t sa = probes[a.probe].shell;
        const std::uint32_t sb = probes[b.probe].shell;
        if (sa != sb) return sa < sb;
        return a.shell != b.shell ? a.shell < b.shell : a.probe < b.probe;
    });
    return hits;
}

/// What the probes of a shell show about another one.
struct PairVotes {
    std::uint32_t inner, outer;
    std::size_t inside = 0;   ///< probes of `inner` in `outer`
    std::size_t unclear = 0;  ///< probes that do not count
};

std::vector<PairVotes> votesOf(const TriangleMesh& mesh, const ShellAnalysis& analysis,
                               const std::vector<Probe>& probes) {
    const std::vector<Hit> hits = findHits(mesh, analysis, probes);
    std::vector<PairVotes> votes;
    for (std::size_t i = 0; i < hits.size();) {
        const auto [probe, outer, ignored] = hits[i];
        const std::uint32_t inner = probes[probe].shell;
        if (votes.empty() || votes.back().inner != inner || votes.back().outer != outer)
            votes.push_back({inner, outer});
        bool odd = false, unclear = false;
        for (; i < hits.size() && hits[i].shell == outer && hits[i].probe == probe; ++i) {
            odd = !odd;
            unclear = unclear || hits[i].unclear;
        }
        votes.back().unclear += unclear;
        votes.back().inside += odd && !unclear;
    }
    return votes;
}

std::vector<std::size_t> countsOf(const std::vector<Probe>& probes, std::size_t shells) {
    std::vector<std::size_t> counts(shells);
    for (const Probe& probe : probes) ++counts[probe.shell];
    return counts;
}

/// Sets `depth` of every shell.
void findNesting(const TriangleMesh& mesh, ShellAnalysis& analysis) {
    auto& shells = analysis.shells;
    const bool anyClosed = std::any_of(shells.begin(), shells.end(),
                                       [](const Shell& shell) { return shell.boundaryEdges == 0; });
    if (shells.size() < 2 || !anyClosed) return;
    const std::vector<Probe> probes = probesOf(mesh, analysis);
    const auto counts = countsOf(probes, shells.size());
    for (const PairVotes& pair : votesOf(mesh, analysis, probes)) {
        const std::size_t clear = counts[pair.inner] - pair.unclear;
        // A smaller piece never encloses a larger one: of two that cut each other both might.
        if (static_cast<double>(pair.inside) > kEnclosed * static_cast<double>(clear) &&
            pair.outer < pair.inner)
            ++shells[pair.inner].depth;
    }
}

/// Whether one of the triangles at an edge is marked.
bool hasAny(const std::vector<char>& marked, const EdgeTable::Use* first,
            const EdgeTable::Use* last) {
    return !marked.empty() && std::any_of(first, last, [&](const EdgeTable::Use& use) {
        return marked[use.triangle()] != 0;
    });
}

/// Joins triangles at edges; a piece is named by its first triangle.
/// @param isWhole  whether all triangles at an edge with this one are joined; empty: none are.
DisjointSets joinPieces(const TriangleMesh& mesh, const EdgeTable& edges,
                        const std::vector<char>& isWhole) {
    const std::size_t n = mesh.triangles.size();
    DisjointSets pieces(n);
    const auto join = [&](const EdgeTable::Use& a, const EdgeTable::Use& b) {
        pieces.join(a.triangle(), b.triangle());
    };
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        if (last - first < 3 || edges.surplus(first, last) != 0 || hasAny(isWhole, first, last)) {
            for (const auto* use = first + 1; use < last; ++use) join(*first, *use);
            return;
        }
        auto pairs = pairSheets(mesh, edges, lower, upper, first, last, CommonWalls::cancel);
        std::stable_partition(pairs.begin(), pairs.end(),
                              [](const SheetPair& pair) { return !pair.isWall; });
        for (const SheetPair& pair : pairs) {
            join(pair.begin, pair.end);
            // A wall in common goes with the solids.
            if (pair.isWall) join(pairs.front().begin, pair.begin);
        }
    });

    // A collapsed triangle has no edges of its own and joins a piece at one of its corners.
    std::vector<std::uint32_t> atVertex;
    for (std::size_t i = 0; i < n; ++i) {
        if (!isCollapsed(mesh.triangles[i])) continue;
        if (atVertex.empty()) {
            atVertex.assign(mesh.vertices.size(), kNone);
            for (std::size_t k = 0; k < n; ++k)
                if (!isCollapsed(mesh.triangles[k]))
                    for (const auto v : mesh.triangles[k])
                        if (atVertex[v] == kNone) atVertex[v] = static_cast<std::uint32_t>(k);
        }
        for (const auto v : mesh.triangles[i]) {
            if (atVertex[v] == kNone) continue;
            pieces.join(atVertex[v], static_cast<std::uint32_t>(i));
            break;
        }
    }
    return pieces;
}

/// Fills `shellOfTriangle` and the shells' numbers of triangles, in the order of first triangles.
/// @return a point of each shell.
std::vector<Vec<3>> nameShells(const TriangleMesh& mesh, DisjointSets pieces,
                               ShellAnalysis& result) {
    const std::size_t n = mesh.triangles.size();
    std::vector<Vec<3>> origins;
    std::vector<std::uint32_t> shellOfRoot(n, kNone);
    result.shellOfTriangle.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t root = pieces.find(static_cast<std::uint32_t>(i));
        if (shellOfRoot[root] == kNone) {
            shellOfRoot[root] = static_cast<std::uint32_t>(result.shells.size());
            result.shells.emplace_back();
            origins.push_back(mesh.vertices[mesh.triangles[i][0]]);
        }
        result.shellOfTriangle[i] = shellOfRoot[root];
        ++result.shells[shellOfRoot[root]].triangles;
    }
    return origins;
}

/// Edges at which the triangles of a shell do not cancel.
struct OpenEdges {
    std::vector<std::array<std::uint32_t, 2>> edges;
    std::vector<std::pair<std::uint32_t, double>> uses;  ///< shell; forward less backward uses
};

/// Counts the shells' boundary edges. @return their open edges.
OpenEdges findOpenEdges(const EdgeTable& edges, ShellAnalysis& result) {
    OpenEdges open;
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        const std::uint32_t s = result.shellOfTriangle[first->triangle()];
        if (last - first == 1) ++result.shells[s].boundaryEdges;
        const int forward = edges.surplus(first, last);
        if (forward == 0) return;
        open.edges.push_back({lower, upper});
        open.uses.emplace_back(s, forward);
    });
    return open;
}

/// Adds six times the volume of the cones between open edges and the middles of their groups:
/// without them the sum over the triangles of an open surface depends on the origin.
void closeByCones(const TriangleMesh& mesh, const OpenEdges& open,
                  const std::vector<Vec<3>>& origins, ShellAnalysis& result) {
    struct Middle {
        Vec<3> offset;  // of the mean of the edges from the first vertex of the group
        double edges = 0;
        std::uint32_t first = 0;
    };
    const auto& edges = open.edges;
    const auto group = groupEdges(edges);
    std::vector<Middle> middles(
        edges.empty() ? 0 : *std::max_element(group.begin(), group.end()) + std::size_t{1});
    for (std::size_t i = 0; i < edges.size(); ++i) {
        auto& middle = middles[group[i]];
        if (middle.edges == 0) middle.first = edges[i][0];
        ++middle.edges;
        for (const auto v : edges[i])
            middle.offset += (mesh.vertices[v] - mesh.vertices[middle.first]) * 0.5;
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& middle = middles[group[i]];
        const auto [s, forward] = open.uses[i];
        const Vec<3> apex = mesh.vertices[middle.first] + middle.offset * (1.0 / middle.edges);
        result.shells[s].signedVolume -=
            forward * dot(mesh.vertices[edges[i][0]] - origins[s],
                          cross(mesh.vertices[edges[i][1]] - origins[s], apex - origins[s]));
    }
}

void measureVolumes(const TriangleMesh& mesh, const EdgeTable& edges,
                    const std::vector<Vec<3>>& origins, ShellAnalysis& result) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::uint32_t s = result.shellOfTriangle[i];
        const auto& t = mesh.triangles[i];
        const Vec<3>& origin = origins[s];
        result.shells[s].signedVolume +=
            dot(mesh.vertices[t[0]] - origin,
                cross(mesh.vertices[t[1]] - origin, mesh.vertices[t[2]] - origin));
    }
    closeByCones(mesh, findOpenEdges(edges, result), origins, result);
    for (auto& shell : result.shells) shell.signedVolume /= 6.0;
}

/// Orders shells by falling volume; the order of the triangles breaks ties.
void sortByVolume(ShellAnalysis& result) {
    std::vector<std::pair<double, std::uint32_t>> order;  // less the volume, index
    order.reserve(result.shells.size());
    for (const Shell& shell : result.shells)
        order.emplace_back(-std::fabs(shell.signedVolume),
                           static_cast<std::uint32_t>(order.size()));
    tbb::parallel_sort(order.begin(), order.end());
    std::vector<std::uint32_t> rank(order.size());
    std::vector<Shell> sorted(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
        rank[order[k].second] = static_cast<std::uint32_t>(k);
        sorted[k] = result.shells[order[k].second];
    }
    result.shells = std::move(sorted);
    for (auto& s : result.shellOfTriangle) s = rank[s];
}

/// The shells, joined as `joinPieces` does.
ShellAnalysis splitShells(const TriangleMesh& mesh, const EdgeTable& edges,
                          const std::vector<char>& isWhole) {
    ShellAnalysis result;
    const auto origins = nameShells(mesh, joinPieces(mesh, edges, isWhole), result);
    measureVolumes(mesh, edges, origins, result);
    sortByVolume(result);
    findNesting(mesh, result);
    return result;
}

}  // namespace

double ShellAnalysis::enclosedVolume() const {
    double sum = 0;
    for (const auto& shell : shells)
        sum += (shell.depth % 2 == 0 ? 1.0 : -1.0) * std::fabs(shell.signedVolume);
    return sum;
}

ShellAnalysis analyzeShells(const TriangleMesh& mesh, const EdgeTable& edges) {
    ShellAnalysis result = splitShells(mesh, edges, {});
    // A shell that faces outward in another and shares an edge with it may overlap it as well as
    // bound a cavity: no volume is known of the two.
    const auto isDoubtful = [](const Shell& shell) {
        return shell.depth > 0 && (shell.signedVolume > 0) != (shell.depth % 2 == 0);
    };
    if (std::none_of(result.shells.begin(), result.shells.end(), isDoubtful)) return result;
    std::vector<char> isWhole(mesh.triangles.size(), 0);
    for (std::size_t i = 0; i < isWhole.size(); ++i)
        isWhole[i] = isDoubtful(result.shells[result.shellOfTriangle[i]]);
    bool sharesEdge = false;
    edges.forEach(
        [&](std::uint32_t, std::uint32_t, const EdgeTable::Use* first, const EdgeTable::Use* last) {
            sharesEdge = sharesEdge || (last - first > 2 && hasAny(isWhole, first, last));
        });
    return sharesEdge ? splitShells(mesh, edges, isWhole) : result;
}

ShellAnalysis analyzeShells(const TriangleMesh& mesh) {
    return analyzeShells(mesh, EdgeTable(mesh));
}

TriangleMesh outermostShells(const TriangleMesh& mesh, const ShellAnalysis& shells) {
    TriangleMesh outermost;
    outermost.vertices = mesh.vertices;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (shells.shells[shells.shellOfTriangle[i]].depth == 0)
            outermost.triangles.push_back(mesh.triangles[i]);
    return outermost;
}

}  // namespace vdbpack
