#include "vdbpack/mesh/mesh_sides.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/mesh/vertical_line.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace vdbpack {

MeshSides::Columns::Columns(TriangleMesh m) : mesh(std::move(m)), bounds(mesh.bounds()) {
    // About two columns a triangle keeps both the lists and their overlaps short.
    const double w = std::max(bounds.size()[0], 1e-300);
    const double h = std::max(bounds.size()[1], 1e-300);
    const double wanted = 2.0 * static_cast<double>(mesh.triangles.size()) + 1;
    const double edge = std::sqrt(w * h / wanted);
    const double extent[2] = {w, h};
    for (int a = 0; a < 2; ++a) {
        count[a] = static_cast<int>(std::clamp(std::ceil(extent[a] / edge), 1.0, 4096.0));
        perLength[a] = count[a] / extent[a];
    }
    const auto forEachCell = [&](const std::array<std::uint32_t, 3>& t, const auto& visit) {
        Box<3> box;
        for (const std::uint32_t v : t) box.add(mesh.vertices[v]);
        for (int j = index(box.lo[1], 1); j <= index(box.hi[1], 1); ++j)
            for (int i = index(box.lo[0], 0); i <= index(box.hi[0], 0); ++i)
                visit(static_cast<std::size_t>(j) * static_cast<std::size_t>(count[0]) +
                      static_cast<std::size_t>(i));
    };
    std::vector<std::atomic<std::uint32_t>> next(static_cast<std::size_t>(count[0]) *
                                                 static_cast<std::size_t>(count[1]));
    forAll(mesh.triangles.size(), [&](std::size_t k) {
        forEachCell(mesh.triangles[k],
                    [&](std::size_t cell) { next[cell].fetch_add(1, std::memory_order_relaxed); });
    });
    triangles.resize(firstPositions(next, start, "triangles over the cells of a plane",
                                    "use a mesh of fewer triangles"));
    // In any order: crossings are counted.
    forAll(mesh.triangles.size(), [&](std::size_t k) {
        forEachCell(mesh.triangles[k], [&](std::size_t cell) {
            triangles[next[cell].fetch_add(1, std::memory_order_relaxed)] =
                static_cast<std::uint32_t>(k);
        });
    });
}

int MeshSides::Columns::index(double x, int axis) const {
    return static_cast<int>(std::clamp((x - bounds.lo[axis]) * perLength[axis], 0.0,
                                       static_cast<double>(count[axis] - 1)));
}

void MeshSides::Columns::cross(const Vec<3>& x, int& above, int& below) const {
    above = below = 0;
    if (!bounds.contains(x)) return;
    const std::size_t cell =
        static_cast<std::size_t>(index(x[1], 1)) * static_cast<std::size_t>(count[0]) +
        static_cast<std::size_t>(index(x[0], 0));
    for (std::uint32_t k = start[cell]; k < start[cell + 1]; ++k) {
        const auto& t = mesh.triangles[triangles[k]];
        if (!coversLine(mesh, t, x)) continue;
        // On the wall itself either answer will do.
        ++(heightOver(mesh, t, x) == Height::above ? above : below);
    }
}

/// Cyclic exchange that brings `axis` to z.
Vec<3> MeshSides::turned(const Vec<3>& v, std::size_t axis) {
    return {{v.c[(axis + 1) % 3], v.c[(axis + 2) % 3], v.c[axis]}};
}

MeshSides::MeshSides(const TriangleMesh& mesh, bool clean) {
    for (const std::size_t axis : {std::size_t{2}, std::size_t{0}, std::size_t{1}}) {
        TriangleMesh copy = mesh;
        for (auto& v : copy.vertices) v = turned(v, axis);
        axes_.emplace_back(std::move(copy));
        if (clean) break;
    }
}

bool MeshSides::inside(const Vec<3>& x) const {
    int above = 0, below = 0;
    if (axes_.size() == 1) {
        axes_.front().cross(x, above, below);
        return above % 2 == 1;
    }
    int votes = 0;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
        axes_[a].cross(turned(x, std::array<std::size_t, 3>{2, 0, 1}[a]), above, below);
        votes += above % 2 + below % 2;
    }
    return votes > 3;
}

}  // namespace vdbpack
