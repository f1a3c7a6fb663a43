#include "vdbpack/mesh/shell_intersections.h"

#include "vdbpack/core/weyl.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/mesh/triangle_crossing.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// How far from a corner of a triangle to its middle a point shows where the corner is.
constexpr double kFromCorner = 1e-3;
/// Points by which shared volumes are estimated: of all pairs together, and of each at least.
constexpr std::size_t kMostPoints = 65536, kLeastPoints = 64;

class Intersections {
public:
    Intersections(const TriangleMesh& mesh, const ShellAnalysis& analysis)
        : mesh_(mesh), analysis_(analysis), boxes_(analysis.shells.size()) {}

    ShellIntersections find() {
        selectTriangles();
        if (selected_.empty()) return {};
        const TriangleTree tree(selected_.size(), [&](std::size_t i) { return corners(i); });
        for (std::size_t i = 0; i < selected_.size(); ++i) {
            const Box<3> box = boxOf(selected_[i]);
            tree.visitNear(box.center(), 0.25 * squaredLength(box.size()), [&](std::uint32_t k) {
                // Each pair of triangles once.
                if (k > i && shellOf(k) != shellOf(i) && overlap(box, boxOf(selected_[k])))
                    compare(i, k);
                return false;
            });
        }
        ShellIntersections found;
        found.pairs = pairs_.size();
        double largest = 0;
        for (const auto& [a, b] : pairs_) {
            const auto [volume, middle] = shared(a, b);
            found.volume += volume;
            if (volume > largest) found.at = middle;
            largest = std::max(largest, volume);
        }
        return found;
    }

private:
    std::uint32_t shellOf(std::size_t i) const { return analysis_.shellOfTriangle[selected_[i]]; }
    Box<3> boxOf(std::uint32_t triangle) const {
        Box<3> box;
        for (const std::uint32_t v : mesh_.triangles[triangle]) box.add(mesh_.vertices[v]);
        return box;
    }

    /// Of a triangle, facing outward.
    TriangleTree::Corners outward(std::uint32_t triangle) const {
        TriangleTree::Corners c = cornersOf(mesh_, mesh_.triangles[triangle]);
        if (analysis_.shells[analysis_.shellOfTriangle[triangle]].signedVolume < 0)
            std::swap(c[1], c[2]);
        return c;
    }
    TriangleTree::Corners corners(std::size_t i) const { return outward(selected_[i]); }

    /// Selects the triangles of closed shells that reach into boxes around others.
    void selectTriangles() {
        for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
            const Box<3> box = boxOf(i);
            boxes_[analysis_.shellOfTriangle[i]].add(box.lo);
            boxes_[analysis_.shellOfTriangle[i]].add(box.hi);
        }
        std::vector<std::uint32_t> order;
        for (std::uint32_t s = 0; s < boxes_.size(); ++s)
            if (analysis_.shells[s].boundaryEdges == 0) order.push_back(s);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return boxes_[a].lo[0] < boxes_[b].lo[0];
        });
        std::vector<Box<3>> common(boxes_.size());  // around what each shares with others
        for (std::size_t a = 0; a < order.size(); ++a)
            for (std::size_t b = a + 1; b < order.size(); ++b) {
                if (boxes_[order[b]].lo[0] > boxes_[order[a]].hi[0]) break;
                const Box<3> both = intersection(boxes_[order[a]], boxes_[order[b]]);
                if (both.empty()) continue;
                for (const std::uint32_t s : {order[a], order[b]}) {
                    common[s].add(both.lo);
                    common[s].add(both.hi);
                }
            }
        for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
            if (overlap(boxOf(i), common[analysis_.shellOfTriangle[i]])) selected_.push_back(i);
    }

    /// The inside test of a shell, made when it is first asked for.
    const MeshSides& sidesOf(std::uint32_t shell) {
        const auto found = sides_.find(shell);
        if (found != sides_.end()) return found->second;
        if (trianglesOf_.empty()) {
            trianglesOf_.resize(boxes_.size());
            for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
                trianglesOf_[analysis_.shellOfTriangle[i]].push_back(i);
        }
        TriangleMesh own;
        std::unordered_map<std::uint32_t, std::uint32_t> index;  // of a vertex in `own`
        for (const std::uint32_t i : trianglesOf_[shell]) {
            auto t = mesh_.triangles[i];
            for (std::uint32_t& v : t) {
                const auto next = static_cast<std::uint32_t>(own.vertices.size());
                const auto [at, isNew] = index.try_emplace(v, next);
                if (isNew) own.vertices.push_back(mesh_.vertices[v]);
                v = at->second;
            }
            own.triangles.push_back(t);
        }
        return sides_.emplace(shell, MeshSides(own, true)).first->second;
    }

    /// Whether a shell lies in a larger one, which it may touch from inside: by points of all its
    /// triangles, near their middles and corners.
    bool isNested(std::uint32_t shell, std::uint32_t larger, double tolerance) {
        sidesOf(shell);
        const MeshSides& around = sidesOf(larger);
        for (const std::uint32_t triangle : trianglesOf_[shell]) {
            const TriangleTree::Corners c = outward(triangle);
            const Vec<3> normal = cross(c[1] - c[0], c[2] - c[0]);
            if (!(squaredLength(normal) > 0)) continue;
            const Vec<3> back = normalized(normal) * -tolerance;
            const Vec<3> middle = (c[0] + c[1] + c[2]) * (1.0 / 3);
            if (!around.inside(middle + back)) return false;
            for (const Vec<3>& corner : c)
                if (!around.inside(corner + (middle - corner) * kFromCorner + back)) return false;
        }
        return true;
    }

    void compare(std::size_t i, std::size_t k) {
        const std::uint32_t a = shellOf(i), b = shellOf(k);
        const std::pair<std::uint32_t, std::uint32_t> pair = std::minmax(a, b);
        if (pairs_.count(pair) + nested_.count(pair) > 0) return;
        const double tolerance =
            kTouching * std::min(length(boxes_[a].size()), length(boxes_[b].size()));
        const auto inA = [&](const Vec<3>& x) { return sidesOf(a).inside(x); };
        const auto inB = [&](const Vec<3>& x) { return sidesOf(b).inside(x); };
        if (!anyEdgePasses(corners(i), corners(k), inB, tolerance) &&
            !anyEdgePasses(corners(k), corners(i), inA, tolerance))
            return;
        // By falling volume.
        (isNested(pair.second, pair.first, tolerance) ? nested_ : pairs_).insert(pair);
    }

    /// The volume inside both, and its middle.
    std::pair<double, Vec<3>> shared(std::uint32_t a, std::uint32_t b) {
        const std::size_t points = std::max(kLeastPoints, kMostPoints / pairs_.size());
        const Box<3> box = intersection(boxes_[a], boxes_[b]);
        std::size_t inside = 0;
        Vec<3> sum;
        for (std::size_t n = 0; n < points; ++n) {
            const Vec<3> x = weylPoint(n, box);
            if (!sidesOf(a).inside(x) || !sidesOf(b).inside(x)) continue;
            ++inside;
            sum += x;
        }
        const double share = static_cast<double>(inside) / static_cast<double>(points);
        return {share * box.volume(),
                sum * (1.0 / static_cast<double>(std::max<std::size_t>(inside, 1)))};
    }

    const TriangleMesh& mesh_;
    const ShellAnalysis& analysis_;
    std::vector<Box<3>> boxes_;                            ///< of the shells
    std::vector<std::uint32_t> selected_;                  ///< triangles
    std::vector<std::vector<std::uint32_t>> trianglesOf_;  ///< by shell; once asked for
    std::map<std::uint32_t, MeshSides> sides_;
    /// Of two shells, the larger first.
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs_, nested_;
};

}  // namespace

ShellIntersections findIntersections(const TriangleMesh& mesh, const ShellAnalysis& analysis) {
    return analysis.shells.size() < 2 ? ShellIntersections{} : Intersections(mesh, analysis).find();
}

}  // namespace vdbpack
