#include "vdbpack/repair/repair_changes.h"

#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/triangle_tree.h"
#include "vdbpack/repair/facing.h"
#include "vdbpack/repair/sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace vdbpack {

namespace {

/// About the number of corners of a component that are looked up.
constexpr std::size_t kCorners = 500;
/// A component is removed if fewer of its corners than this share are found again.
constexpr double kFound = 0.02;
/// Smallest reach, as a share of the size of the surface: rounding to 32 bits.
constexpr double kRounding = 1e-6;

/// A surface split into a manifold, and its components.
struct Split {
    TriangleMesh mesh;
    MeshAnalysis analysis;
    std::vector<char> closed;  ///< [s]: shell s is nearly closed

    explicit Split(const TriangleMesh& surface)
        : mesh(manifoldOf(surface)),
          analysis(analyzeMesh(mesh)),
          closed(nearlyClosed(mesh, analysis.shells)) {}

    bool isSolid(std::size_t s) const {
        return closed[s] != 0 && analysis.shells.shells[s].signedVolume > 0;
    }
    SurfaceTopology topology() const {
        SurfaceTopology t;
        const auto& shells = analysis.shells.shells;
        for (std::size_t s = 0; s < shells.size(); ++s)
            ++(closed[s] == 0 ? t.fragments : isSolid(s) ? t.components : t.cavities);
        const auto& leak = analysis.health.leak;
        t.holes = leak ? static_cast<std::int64_t>(leak->loops) : 0;
        t.eulerNumber = analysis.health.eulerNumber;
        t.handles = (2 * static_cast<std::int64_t>(shells.size()) - t.holes - t.eulerNumber) / 2;
        return t;
    }
};

/// Looks up vertices of a surface.
class VertexSearch {
public:
    VertexSearch(const Split& surface, double reach)
        : surface_(surface),
          reach_(reach),
          tree_(surface.mesh.triangles.size(), [&](std::size_t i) {
              const auto& t = surface.mesh.triangles[i];
              const auto& v = surface.mesh.vertices;
              return TriangleTree::Corners{v[t[0]], v[t[1]], v[t[2]]};
          }) {}

    /// The components of the nearest vertices within reach of `x`: several where they touch.
    std::set<std::uint32_t> nearest(const Vec<3>& x) const {
        double least = reach_ * reach_;
        std::set<std::uint32_t> shells;
        tree_.visitNear(x, least, [&](std::uint32_t triangle) {
            for (const std::uint32_t v : surface_.mesh.triangles[triangle]) {
                const double square = squaredLength(surface_.mesh.vertices[v] - x);
                if (square > least) continue;
                if (square < least) shells.clear();
                least = square;
                shells.insert(surface_.analysis.shells.shellOfTriangle[triangle]);
            }
            return false;
        });
        return shells;
    }

private:
    const Split& surface_;
    double reach_;
    TriangleTree tree_;
};

constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();

/// [s]: the component of `after` that component s of `before` has become; `kNone`: it is gone.
std::vector<std::uint32_t> successors(const Split& before, const Split& after, double reach) {
    const double size = length(before.analysis.health.bounds.size());
    const VertexSearch vertices(after, std::max(reach, kRounding * size));
    const auto& shells = before.analysis.shells;
    struct Votes {
        std::size_t corners = 0;
        std::map<std::uint32_t, std::size_t> of;
    };
    std::vector<Votes> votes(shells.shells.size());
    std::vector<std::size_t> seen(shells.shells.size(), 0);
    for (std::size_t i = 0; i < before.mesh.triangles.size(); ++i) {
        const std::uint32_t s = shells.shellOfTriangle[i];
        const std::size_t step =
            std::max<std::size_t>(1, 3 * shells.shells[s].triangles / kCorners);
        if (seen[s]++ % step != 0) continue;
        for (const std::uint32_t v : before.mesh.triangles[i]) {
            ++votes[s].corners;
            for (const std::uint32_t shell : vertices.nearest(before.mesh.vertices[v]))
                ++votes[s].of[shell];
        }
    }
    std::vector<std::uint32_t> successor(votes.size(), kNone);
    for (std::size_t s = 0; s < votes.size(); ++s) {
        double most = kFound * static_cast<double>(votes[s].corners);
        for (const auto& [shell, n] : votes[s].of)
            if (static_cast<double>(n) > most) {
                most = static_cast<double>(n);
                successor[s] = shell;
            }
    }
    return successor;
}

/// The bounds of each component.
std::vector<Box<3>> boundsOf(const Split& surface) {
    std::vector<Box<3>> bounds(surface.closed.size());
    for (std::size_t i = 0; i < surface.mesh.triangles.size(); ++i)
        for (const std::uint32_t v : surface.mesh.triangles[i])
            bounds[surface.analysis.shells.shellOfTriangle[i]].add(surface.mesh.vertices[v]);
    return bounds;
}

}  // namespace

SurfaceTopology topologyOf(const TriangleMesh& mesh) {
    return Split(mesh).topology();
}

RepairChanges compareSurfaces(const TriangleMesh& before, const TriangleMesh& after, double reach) {
    const Split old(before), now(after);
    RepairChanges changes;
    changes.before = old.topology();
    changes.after = now.topology();
    const auto successor = successors(old, now, reach);
    const std::vector<Box<3>> bounds = boundsOf(old);
    const auto& shells = old.analysis.shells.shells;
    struct Fused {
        std::size_t components = 0;
        double volume = 0;  // of the second largest component
        Vec<3> at;
    };
    std::map<std::uint32_t, Fused> parts;
    // By falling volume, so that the second of several is the second largest.
    for (std::size_t s = 0; s < shells.size(); ++s) {
        if (successor[s] == kNone) {
            if (old.closed[s] == 0) {
                ++changes.fragmentsRemoved;
                continue;
            }
            if (changes.removed++ == 0) changes.removedAt = bounds[s].center();
            changes.removedVolume += std::fabs(shells[s].signedVolume);
        } else if (old.isSolid(s)) {
            auto& part = parts[successor[s]];
            if (++part.components != 2) continue;
            part.volume = shells[s].signedVolume;
            part.at = bounds[s].center();
        }
    }
    for (const auto& [shell, part] : parts) {
        if (part.components < 2) continue;
        ++changes.fusedInto;
        changes.fusedComponents += part.components;
        if (part.volume <= changes.fusedVolume) continue;
        changes.fusedVolume = part.volume;
        changes.fusedAt = part.at;
    }
    return changes;
}

}  // namespace vdbpack
