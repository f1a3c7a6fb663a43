#include "vdbpack/repair/lattice_crossings.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/mesh/vertical_line.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

std::vector<Crossing> latticeCrossings(const TriangleMesh& mesh) {
    PerThread<std::vector<Crossing>> lists;
    for (int axis = 0; axis < 3; ++axis) {
        // Cyclic exchange that brings the axis to z (vertical_line.h).
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        TriangleMesh turned = mesh;
        for (auto& p : turned.vertices) p = Vec<3>{{p[u], p[v], p[axis]}};
        parallelFor(IndexRange(0, turned.triangles.size(), 512), [&](const IndexRange& range) {
            auto& list = lists.local();
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                const auto& t = turned.triangles[i];
                Box<3> box;
                for (const std::uint32_t k : t) box.add(turned.vertices[k]);
                const Vec<3>& a = turned.vertices[t[0]];
                const Vec<3> n = cross(turned.vertices[t[1]] - a, turned.vertices[t[2]] - a);
                if (n[2] == 0) continue;
                const auto facing = static_cast<float>(std::abs(n[2]) / length(n));
                for (double y = std::ceil(box.lo[1]); y <= box.hi[1]; ++y)
                    for (double x = std::ceil(box.lo[0]); x <= box.hi[0]; ++x) {
                        if (!coversLine(turned, t, {{x, y, 0}})) continue;
                        const double z =
                            std::clamp(a[2] - (n[0] * (x - a[0]) + n[1] * (y - a[1])) / n[2],
                                       box.lo[2], box.hi[2]);
                        VoxelIndex lower{};
                        lower[static_cast<std::size_t>(u)] = static_cast<int>(x);
                        lower[static_cast<std::size_t>(v)] = static_cast<int>(y);
                        lower[static_cast<std::size_t>(axis)] = static_cast<int>(std::floor(z));
                        list.push_back(
                            {edgeKey(lower, axis), static_cast<float>(z - std::floor(z)), facing});
                    }
            }
        });
    }
    std::vector<Crossing> crossings;
    for (const auto& list : lists) crossings.insert(crossings.end(), list.begin(), list.end());
    tbb::parallel_sort(crossings.begin(), crossings.end());
    return crossings;
}

}  // namespace vdbpack
