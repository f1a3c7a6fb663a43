#include "vdbpack/mesh/wall_clearance.h"

#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/mesh/triangle_crossing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::size_t kMostSamples = 4000;
/// Nearest points that are tested, as a share of the extent.
constexpr double kNearest = 1e-6;
/// Share of the area that is neglected.
constexpr double kShare = 0.01;

/// A length and the area that has it.
using Sample = std::pair<double, double>;

double quantile(std::vector<Sample> samples) {
    std::sort(samples.begin(), samples.end());
    double total = 0, sum = 0;
    for (const Sample& s : samples) total += s.second;
    for (const Sample& s : samples)
        if ((sum += s.second) >= kShare * total) return s.first;
    return std::numeric_limits<double>::infinity();
}

}  // namespace

WallClearance wallClearance(const TriangleMesh& mesh, const MeshAnalysis& analysis) {
    const MeshSides sides(mesh, analysis.health.isWatertight());
    const double size = length(mesh.bounds().size());
    std::vector<Sample> walls, gaps;
    const std::size_t stride = mesh.triangles.size() / kMostSamples + 1;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += stride) {
        const auto corners = cornersOf(mesh, mesh.triangles[i]);
        const Vec<3> normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
        const Shell& shell = analysis.shells.shells[analysis.shells.shellOfTriangle[i]];
        const bool isOutward = (shell.signedVolume > 0) == (shell.depth % 2 == 0);
        const Vec<3> out = normalized(normal) * (isOutward ? 1.0 : -1.0);
        const Vec<3> middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3);
        // The last point on the same side.
        const auto clear = [&](const Vec<3>& direction, bool inside) {
            double last = 0;
            for (double d = kNearest * size; d < size; d *= 2) {
                if (sides.inside(middle + direction * d) != inside) return last;
                last = d;
            }
            return std::numeric_limits<double>::infinity();
        };
        if (!(length(normal) > 0)) continue;
        walls.emplace_back(clear(-1.0 * out, true), length(normal));
        // A wall in common has another solid on its other side.
        const double gap = clear(out, false);
        if (gap > 0) gaps.emplace_back(gap, length(normal));
    }
    WallClearance result;
    result.thickness = quantile(std::move(walls));
    result.gap = quantile(std::move(gaps));
    result.isSolid = result.thickness > 0 && std::isfinite(result.thickness);
    return result;
}

}  // namespace vdbpack
