#include "vdbpack/repair/repair_changes.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/repair/facing.h"
#include "vdbpack/repair/sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>
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

/// The vertices of a surface in cubic cells, each with its component.
class VertexCells {
public:
    VertexCells(const Split& surface, double reach) : reach_(reach) {
        const auto& mesh = surface.mesh;
        std::vector<char> known(mesh.vertices.size(), 0);
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            for (const std::uint32_t v : mesh.triangles[i]) {
                if (known[v] != 0) continue;
                known[v] = 1;
                cells_[keyOf(mesh.vertices[v], 0, 0, 0)].push_back(
                    {mesh.vertices[v], surface.analysis.shells.shellOfTriangle[i]});
            }
    }

    /// The components of the nearest vertices within reach of `x`: several where they touch.
    std::vector<std::uint32_t> nearest(const Vec<3>& x) const {
        double least = reach_ * reach_;
        std::vector<std::pair<double, std::uint32_t>> found;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k) {
                    const auto cell = cells_.find(keyOf(x, i, j, k));
                    if (cell == cells_.end()) continue;
                    for (const Entry& entry : cell->second) {
                        const double d = squaredLength(entry.at - x);
                        if (d > least) continue;
                        least = d;
                        found.emplace_back(d, entry.shell);
                    }
                }
        std::vector<std::uint32_t> shells;
        for (const auto& [d, shell] : found)
            if (d <= least && std::find(shells.begin(), shells.end(), shell) == shells.end())
                shells.push_back(shell);
        return shells;
    }

private:
    struct Entry {
        Vec<3> at;
        std::uint32_t shell;
    };
    std::uint64_t keyOf(const Vec<3>& x, int i, int j, int k) const {
        const int aside[3] = {i, j, k};
        std::uint64_t key = 0;
        for (int d = 0; d < 3; ++d)
            key = mix64(key ^ static_cast<std::uint64_t>(
                                  static_cast<std::int64_t>(std::floor(x[d] / reach_)) + aside[d]));
        return key;
    }
    double reach_;
    std::unordered_map<std::uint64_t, std::vector<Entry>> cells_;
};

constexpr auto kGone = std::numeric_limits<std::uint32_t>::max();

/// [s]: the component of `after` that component s of `before` has become; `kGone`: it is gone.
std::vector<std::uint32_t> successors(const Split& before, const Split& after, double reach) {
    const double size = length(before.analysis.health.bounds.size());
    const VertexCells cells(after, std::max(reach, kRounding * size));
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
            for (const std::uint32_t shell : cells.nearest(before.mesh.vertices[v]))
                ++votes[s].of[shell];
        }
    }
    std::vector<std::uint32_t> successor(votes.size(), kGone);
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
        if (successor[s] == kGone) {
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
