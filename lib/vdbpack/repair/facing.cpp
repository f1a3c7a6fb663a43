#include "vdbpack/repair/facing.h"

#include "vdbpack/mesh/edge_table.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/repair/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// A shell is nearly closed if cones over its holes have less than this share of its area.
constexpr double kNearlyClosed = 0.25;
/// An open shell is flipped if the winding number changes against it by more than this.
constexpr double kClearChange = 0.02;
/// A nearly closed shell bounds a cavity if more than this share of it lies inside others: a tooth
/// lies half inside its socket.
constexpr double kEnclosed = 0.95;
/// About the number of triangles sampled per shell.
constexpr std::size_t kVotes = 64;

double areaOf(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Vec<3>& a = mesh.vertices[t[0]];
    return 0.5 * length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
}

/// Union-find over triangles, with the orientation of each relative to the root of its patch.
class Patches {
public:
    explicit Patches(std::size_t n) : parent_(n), turned_(n, 0) {
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }
    /// Root of the patch of `i`, and whether `i` has the opposite orientation.
    std::pair<std::uint32_t, bool> find(std::uint32_t i) {
        std::uint32_t root = i;
        bool turned = false;
        while (parent_[root] != root) {
            turned = turned != (turned_[root] != 0);
            root = parent_[root];
        }
        bool rest = turned;
        while (parent_[i] != root && i != root) {
            const std::uint32_t next = parent_[i];
            const bool own = turned_[i] != 0;
            parent_[i] = root;
            turned_[i] = rest;
            rest = rest != own;
            i = next;
        }
        return {root, turned};
    }
    /// Joins the patches of two neighbors. @param against  whether they have opposite orientations.
    /// Two triangles of one patch stay as they are: a Moebius band has no consistent orientation.
    void join(std::uint32_t a, std::uint32_t b, bool against) {
        const auto [ra, ta] = find(a);
        const auto [rb, tb] = find(b);
        if (ra == rb) return;
        parent_[std::max(ra, rb)] = std::min(ra, rb);
        turned_[std::max(ra, rb)] = (ta != tb) != against;
    }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<char> turned_;
};

/// Balances the edges with more than two triangles by flipping whole patches, small ones first.
void balance(const TriangleMesh& mesh, const EdgeTable& edges,
             const std::vector<std::uint32_t>& patchOf, std::vector<char>& turn,
             const std::vector<double>& areas) {
    struct Branch {
        std::vector<std::pair<std::uint32_t, int>> sides;  // patch, +1 or -1 in the file
    };
    std::vector<Branch> branches;
    std::vector<std::vector<std::uint32_t>> branchesOf(areas.size());
    edges.forEach(
        [&](std::uint32_t, std::uint32_t, const EdgeTable::Use* first, const EdgeTable::Use* last) {
            if (last - first < 3) return;
            Branch branch;
            for (const auto* use = first; use != last; ++use) {
                const std::uint32_t patch = patchOf[use->triangle()];
                const bool forward = edges.isForward(*use) != (turn[use->triangle()] != 0);
                branch.sides.emplace_back(patch, forward ? 1 : -1);
                auto& list = branchesOf[patch];
                const auto index = static_cast<std::uint32_t>(branches.size());
                if (list.empty() || list.back() != index) list.push_back(index);
            }
            branches.push_back(std::move(branch));
        });
    if (branches.empty()) return;
    std::vector<char> patchTurned(areas.size(), 0);
    const auto imbalance = [&](const Branch& branch, std::uint32_t other) {
        int sum = 0;
        for (const auto& [patch, way] : branch.sides)
            sum += (patchTurned[patch] != 0) != (patch == other) ? -way : way;
        return std::abs(sum);
    };
    std::vector<std::uint32_t> order(areas.size());
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return areas[a] < areas[b]; });
    constexpr auto kNoBranch = static_cast<std::uint32_t>(-1);
    for (int pass = 0; pass < 8; ++pass) {
        bool changed = false;
        for (const std::uint32_t patch : order) {
            int now = 0, then = 0;
            for (const std::uint32_t index : branchesOf[patch]) {
                now += imbalance(branches[index], kNoBranch);
                then += imbalance(branches[index], patch);
            }
            if (then >= now) continue;
            patchTurned[patch] = !patchTurned[patch];
            changed = true;
        }
        if (!changed) break;
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (patchTurned[patchOf[i]] != 0) turn[i] = !turn[i];
}

/// Orients nearly closed shells by their volumes, and the others by the surface around them.
void turnShells(TriangleMesh& mesh, NestedShells nested, std::vector<char>& turned) {
    const ShellAnalysis shells = analyzeShells(mesh);
    const std::vector<char> settled = nearlyClosed(mesh, shells);
    const std::size_t count = settled.size();
    std::vector<char> turnShell(count, 0);
    const auto apply = [&] {
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            if (turnShell[shells.shellOfTriangle[i]] == 0) continue;
            std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
            turned[i] = !turned[i];
        }
        std::fill(turnShell.begin(), turnShell.end(), 0);
    };
    for (std::size_t s = 0; s < count; ++s) {
        turnShell[s] = settled[s] != 0 && shells.shells[s].signedVolume < 0;
    }
    apply();
    if (count == 1) return;

    TriangleMesh closed;
    closed.vertices = mesh.vertices;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (settled[shells.shellOfTriangle[i]] != 0) closed.triangles.push_back(mesh.triangles[i]);
    if (closed.triangles.empty()) return;
    const WindingNumber winding(closed);
    // Sampled triangles of each shell vote, weighted by area.
    struct Vote {
        double area = 0, enclosed = 0, change = 0;
    };
    std::vector<Vote> votes(count);
    std::vector<std::size_t> seen(count, 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::uint32_t s = shells.shellOfTriangle[i];
        const std::size_t step = std::max<std::size_t>(1, shells.shells[s].triangles / kVotes);
        if (seen[s]++ % step != 0) continue;
        const auto& t = mesh.triangles[i];
        const Vec<3>& a = mesh.vertices[t[0]];
        const Vec<3> n = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
        const double twice = length(n);
        if (!(twice > 0)) continue;
        const Vec<3> center = (a + mesh.vertices[t[1]] + mesh.vertices[t[2]]) * (1.0 / 3);
        votes[s].area += twice;
        if (settled[s] != 0) {
            // Just behind the triangle, the shell itself adds 1 to the winding number.
            const double behind = winding(center - n * (1e-3 / std::sqrt(twice)));
            if (std::lround(behind - 1) % 2 == 1) votes[s].enclosed += twice;
        } else {
            const Vec<3> aside = n * (0.5 / std::sqrt(twice));
            votes[s].change += twice * (winding(center - aside) - winding(center + aside));
        }
    }
    for (std::size_t s = 0; s < count; ++s)
        turnShell[s] = settled[s] != 0 ? nested == NestedShells::cavity &&
                                             votes[s].enclosed > kEnclosed * votes[s].area
                                       : votes[s].change < -kClearChange * votes[s].area;
    apply();
}

}  // namespace

std::vector<char> nearlyClosed(const TriangleMesh& mesh, const ShellAnalysis& shells) {
    std::vector<double> area(shells.shells.size(), 0), coneArea(shells.shells.size(), 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        area[shells.shellOfTriangle[i]] += areaOf(mesh, mesh.triangles[i]);

    // The volume of a shell includes a cone from the middle of each hole (mesh_shells.h).
    std::vector<std::array<std::uint32_t, 2>> open;
    std::vector<std::uint32_t> shellOfEdge;
    const EdgeTable edges(mesh);
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        if (edges.surplus(first, last) == 0) return;
        open.push_back({lower, upper});
        shellOfEdge.push_back(shells.shellOfTriangle[first->triangle()]);
    });
    const auto hole = groupEdges(open);
    std::vector<Vec<3>> middle;
    std::vector<double> weight;
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (hole[i] >= middle.size()) {
            middle.resize(hole[i] + 1);
            weight.resize(hole[i] + 1, 0);
        }
        for (const std::uint32_t v : open[i]) {
            middle[hole[i]] += mesh.vertices[v];
            ++weight[hole[i]];
        }
    }
    for (std::size_t i = 0; i < open.size(); ++i) {
        const Vec<3> apex = middle[hole[i]] * (1 / weight[hole[i]]);
        const Vec<3> a = mesh.vertices[open[i][0]] - apex;
        coneArea[shellOfEdge[i]] += 0.5 * length(cross(a, mesh.vertices[open[i][1]] - apex));
    }
    std::vector<char> closed(area.size(), 0);
    for (std::size_t s = 0; s < closed.size(); ++s)
        closed[s] = coneArea[s] < kNearlyClosed * area[s];
    return closed;
}

std::size_t turnOutward(TriangleMesh& mesh, NestedShells nested) {
    const std::size_t n = mesh.triangles.size();
    std::vector<char> turn(n, 0);
    {
        const EdgeTable edges(mesh);
        Patches patches(n);
        edges.forEach([&](std::uint32_t, std::uint32_t, const EdgeTable::Use* first,
                          const EdgeTable::Use* last) {
            if (last - first != 2) return;
            const bool against = edges.isForward(first[0]) == edges.isForward(first[1]);
            patches.join(first[0].triangle(), first[1].triangle(), against);
        });
        // A patch keeps the orientation that most of its area has in the file.
        std::vector<std::uint32_t> patchOf(n);
        std::vector<std::uint32_t> number(n, 0);
        std::vector<double> with, against;
        for (std::uint32_t i = 0; i < n; ++i) {
            const auto [root, turned] = patches.find(i);
            if (root == i) {
                number[i] = static_cast<std::uint32_t>(with.size());
                with.push_back(0);
                against.push_back(0);
            }
            patchOf[i] = number[root];
            turn[i] = turned;
            (turned ? against : with)[patchOf[i]] += areaOf(mesh, mesh.triangles[i]);
        }
        std::vector<double> areas(with.size());
        for (std::size_t p = 0; p < areas.size(); ++p) areas[p] = with[p] + against[p];
        for (std::size_t i = 0; i < n; ++i)
            if (against[patchOf[i]] > with[patchOf[i]]) turn[i] = !turn[i];
        balance(mesh, edges, patchOf, turn, areas);
    }
    for (std::size_t i = 0; i < n; ++i)
        if (turn[i] != 0) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    turnShells(mesh, nested, turn);
    return static_cast<std::size_t>(std::count(turn.begin(), turn.end(), char{1}));
}

}  // namespace vdbpack
