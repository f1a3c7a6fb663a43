#include "vdbpack/mesh/mesh_sides.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/mesh/vertical_line.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

namespace vdbpack {

namespace {

/// Cells a triangle, on average, above which triangles go to a tree; a plain bone has about 6, a
/// skull of many folds more than 24.
constexpr double kMostCells = 100;
/// Meshes with fewer places in cells never do.
constexpr double kSmall = 65536;

}  // namespace

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
    if (!fillCells())
        tree = TriangleTree(mesh.triangles.size(), [&](std::size_t k) {
            const auto& t = mesh.triangles[k];
            return TriangleTree::Corners{mesh.vertices[t[0]], mesh.vertices[t[1]],
                                         mesh.vertices[t[2]]};
        });
}

/// Lists the triangles by cells. @return false if they lie over too many.
bool MeshSides::Columns::fillCells() {
    struct Range {
        int i0, i1, j0, j1;
    };
    const auto rangeOf = [&](std::size_t k) {
        Box<3> box;
        for (const std::uint32_t v : mesh.triangles[k]) box.add(mesh.vertices[v]);
        return Range{index(box.lo[0], 0), index(box.hi[0], 0), index(box.lo[1], 1),
                     index(box.hi[1], 1)};
    };
    const std::size_t n = mesh.triangles.size();
    const double places = tbb::parallel_reduce(
        IndexRange(0, n, 4096), 0.0,
        [&](const IndexRange& part, double sum) {
            for (std::size_t k = part.begin(); k < part.end(); ++k) {
                const Range r = rangeOf(k);
                sum += (r.i1 - r.i0 + 1.0) * (r.j1 - r.j0 + 1.0);
            }
            return sum;
        },
        std::plus<>());
    if (places > kMostCells * static_cast<double>(n) + kSmall) return false;
    const auto forEachCell = [&](std::size_t k, const auto& visit) {
        const Range r = rangeOf(k);
        for (int j = r.j0; j <= r.j1; ++j)
            for (int i = r.i0; i <= r.i1; ++i)
                visit(static_cast<std::size_t>(j) * static_cast<std::size_t>(count[0]) +
                      static_cast<std::size_t>(i));
    };
    std::vector<std::atomic<std::uint32_t>> next(static_cast<std::size_t>(count[0]) *
                                                 static_cast<std::size_t>(count[1]));
    forAll(n, [&](std::size_t k) {
        forEachCell(k,
                    [&](std::size_t cell) { next[cell].fetch_add(1, std::memory_order_relaxed); });
    });
    triangles.resize(firstPositions(next, start, "triangles over the cells of a plane",
                                    "use a mesh of fewer triangles"));
    // In any order: crossings are counted.
    forAll(n, [&](std::size_t k) {
        forEachCell(k, [&](std::size_t cell) {
            triangles[next[cell].fetch_add(1, std::memory_order_relaxed)] =
                static_cast<std::uint32_t>(k);
        });
    });
    return true;
}

int MeshSides::Columns::index(double x, int axis) const {
    return static_cast<int>(std::clamp((x - bounds.lo[axis]) * perLength[axis], 0.0,
                                       static_cast<double>(count[axis] - 1)));
}

void MeshSides::Columns::cross(const Vec<3>& x, int& above, int& below) const {
    above = below = 0;
    if (!bounds.contains(x)) return;
    const auto crossOne = [&](std::uint32_t triangle) {
        const auto& t = mesh.triangles[triangle];
        if (!coversLine(mesh, t, x)) return;
        // On the wall itself either answer will do.
        ++(heightOver(mesh, t, x) == Height::above ? above : below);
    };
    if (!tree.empty()) {
        tree.visitAlongZ(x, crossOne);
        return;
    }
    const std::size_t cell =
        static_cast<std::size_t>(index(x[1], 1)) * static_cast<std::size_t>(count[0]) +
        static_cast<std::size_t>(index(x[0], 0));
    for (std::uint32_t k = start[cell]; k < start[cell + 1]; ++k) crossOne(triangles[k]);
}

/// Cyclic exchange that brings `axis` to z.
Vec<3> MeshSides::turned(const Vec<3>& v, std::size_t axis) {
    return {{v.c[(axis + 1) % 3], v.c[(axis + 2) % 3], v.c[axis]}};
}

MeshSides::MeshSides(const TriangleMesh& mesh, bool clean) {
    // Of a clean mesh one axis will do: z, or that across a mesh long in z, whose lines pass fewer
    // triangles.
    const Vec<3> size = mesh.bounds().size();
    const std::size_t across = size[0] < size[1] ? 0 : 1;
    first_ = clean && size[2] > 2 * size.c[across] ? across : 2;
    for (std::size_t k = 0; k < (clean ? 1u : 3u); ++k) {
        TriangleMesh copy = mesh;
        for (auto& v : copy.vertices) v = turned(v, (first_ + k) % 3);
        axes_.emplace_back(std::move(copy));
    }
}

bool MeshSides::inside(const Vec<3>& x) const {
    int above = 0, below = 0;
    if (axes_.size() == 1) {
        axes_.front().cross(turned(x, first_), above, below);
        return above % 2 == 1;
    }
    int votes = 0;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
        axes_[a].cross(turned(x, (first_ + a) % 3), above, below);
        votes += above % 2 + below % 2;
    }
    return votes > 3;
}

}  // namespace vdbpack
