#include "vdbpack/mesh/mesh_axes.h"

#include <cmath>
#include <limits>

namespace vdbpack {

std::optional<PrincipalAxes<3>> principalAxes(const TriangleMesh& mesh,
                                              const MeshAnalysis& analysis) {
    if (!analysis.health.isClosed() || analysis.health.enclosesNothing()) return std::nullopt;
    const ShellAnalysis& shells = analysis.shells;
    const Vec<3> origin = analysis.health.bounds.center();
    SolidMoments<3> inside;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        const auto corner = [&](std::size_t i) {
            return mesh.vertices[mesh.triangles[k][i]] - origin;
        };
        const Vec<3> a = corner(0), b = corner(1), c = corner(2), sum = a + b + c;
        const Shell& shell = shells.shells[shells.shellOfTriangle[k]];
        const bool isCavity = shell.depth % 2 == 1, isInward = shell.signedVolume < 0;
        // The tetrahedron over the triangle: its integral of x xᵀ is that of points at its corners
        // (the origin is one) and four times their mean, a twentieth of its volume each.
        const double volume = (isCavity == isInward ? 1 : -1) * dot(a, cross(b, c)) / 6;
        for (const Vec<3>& x : {a, b, c, sum}) inside.add(volume / 20, x);
        inside.volume += volume * (1 - 4.0 / 20);
        inside.first += sum * (volume * (1.0 / 4 - 2.0 / 20));
    }
    PrincipalAxes<3> found = inside.axes(origin);
    for (std::size_t d = 0; d < 3; ++d) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const auto& triangle : mesh.triangles)
            for (const auto vertex : triangle) {
                const double along = dot(found.axes[d], mesh.vertices[vertex] - origin);
                low = std::min(low, along);
                high = std::max(high, along);
            }
        found.lengths.c[d] = high - low;
    }
    return found;
}

}  // namespace vdbpack
