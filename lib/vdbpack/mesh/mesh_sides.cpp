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

/// Cells a triangle, on average, above which cells are made larger: over a foam lie so many layers
/// that cells by the number of triangles are far smaller than one. A plain bone has about 6.
constexpr double kManyCells = 12, kSmall = 65536;
/// Triangles in the cell of a common entry from which a tree is faster: many are long then.
constexpr double kCrowded = 512;

}  // namespace

MeshSides::Columns::Columns(SharedMesh mesh) : shared(std::move(mesh)), bounds(shared->bounds()) {
    // About two columns a triangle keeps both the lists and their overlaps short.
    const Vec<3> size = bounds.size();
    const auto n = static_cast<double>(shared->triangles.size());
    double edge = std::sqrt(std::max(size[0], 1e-300) * std::max(size[1], 1e-300) / (2 * n + 1));
    setCells(edge);
    while (places() > kManyCells * n + kSmall && count[0] * count[1] > 1) setCells(edge *= 1.4);
    fillCells();
    if (crowding(start) <= kCrowded) return;
    std::vector<std::uint32_t>().swap(start);
    std::vector<std::uint32_t>().swap(triangles);
    tree = TriangleTree(shared->triangles.size(), [&](std::size_t k) {
        const auto& t = shared->triangles[k];
        return TriangleTree::Corners{shared->vertices[t[0]], shared->vertices[t[1]],
                                     shared->vertices[t[2]]};
    });
}

void MeshSides::Columns::setCells(double edge) {
    for (int a = 0; a < 2; ++a) {
        const double extent = std::max(bounds.size()[a], 1e-300);
        count[a] = static_cast<int>(std::clamp(std::ceil(extent / edge), 1.0, 4096.0));
        perLength[a] = count[a] / extent;
    }
}

MeshSides::Columns::Range MeshSides::Columns::rangeOf(std::size_t triangle) const {
    Box<3> box;
    for (const std::uint32_t v : shared->triangles[triangle]) box.add(shared->vertices[v]);
    return {index(box.lo[0], 0), index(box.hi[0], 0), index(box.lo[1], 1), index(box.hi[1], 1)};
}

template <class Visit>
void MeshSides::Columns::forEachCell(std::size_t triangle, const Visit& visit) const {
    const Range r = rangeOf(triangle);
    for (int j = r.j0; j <= r.j1; ++j)
        for (int i = r.i0; i <= r.i1; ++i)
            visit(static_cast<std::size_t>(j) * static_cast<std::size_t>(count[0]) +
                  static_cast<std::size_t>(i));
}

/// Over all triangles, the cells that each meets.
double MeshSides::Columns::places() const {
    return tbb::parallel_reduce(
        IndexRange(0, shared->triangles.size(), 4096), 0.0,
        [&](const IndexRange& part, double sum) {
            for (std::size_t k = part.begin(); k < part.end(); ++k) {
                const Range r = rangeOf(k);
                sum += (r.i1 - r.i0 + 1.0) * (r.j1 - r.j0 + 1.0);
            }
            return sum;
        },
        std::plus<>());
}

/// Lists the triangles by cells.
void MeshSides::Columns::fillCells() {
    const std::size_t n = shared->triangles.size();
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
}

int MeshSides::Columns::index(double x, int axis) const {
    return static_cast<int>(std::clamp((x - bounds.lo[axis]) * perLength[axis], 0.0,
                                       static_cast<double>(count[axis] - 1)));
}

MeshSides::Columns::Crossings MeshSides::Columns::cross(const Vec<3>& x) const {
    Crossings found;
    if (!bounds.contains(x)) return found;
    const auto crossOne = [&](std::uint32_t triangle) {
        const auto& t = shared->triangles[triangle];
        const int turns = turnsAround(*shared, t, x);
        if (turns == 0) return;
        // On the wall itself either answer will do.
        const bool isAbove = heightOver(*shared, t, x) == Height::above;
        ++(isAbove ? found.above : found.below);
        if (isAbove) found.turns += turns;
    };
    if (!tree.empty()) {
        tree.visitAlongZ(x, crossOne);
        return found;
    }
    const std::size_t cell =
        static_cast<std::size_t>(index(x[1], 1)) * static_cast<std::size_t>(count[0]) +
        static_cast<std::size_t>(index(x[0], 0));
    for (std::uint32_t k = start[cell]; k < start[cell + 1]; ++k) crossOne(triangles[k]);
    return found;
}

/// Cyclic exchange that brings `axis` to z.
Vec<3> MeshSides::turned(const Vec<3>& v, std::size_t axis) {
    return {{v.c[(axis + 1) % 3], v.c[(axis + 2) % 3], v.c[axis]}};
}

MeshSides::MeshSides(const SharedMesh& mesh, bool clean) {
    // Of a clean mesh one axis will do: z, or that across a mesh long in z, whose lines pass fewer
    // triangles.
    const Vec<3> size = mesh->bounds().size();
    const std::size_t across = size[0] < size[1] ? 0 : 1;
    first_ = clean && size[2] > 2 * size.c[across] ? across : 2;
    for (std::size_t k = 0; k < (clean ? 1u : 3u); ++k) {
        const std::size_t axis = (first_ + k) % 3;
        if (axis == 2) {
            axes_.emplace_back(mesh);
            continue;
        }
        TriangleMesh copy = *mesh;
        for (auto& v : copy.vertices) v = turned(v, axis);
        axes_.emplace_back(std::make_shared<const TriangleMesh>(std::move(copy)));
    }
}

bool MeshSides::inside(const Vec<3>& x) const {
    if (axes_.size() == 1) return axes_.front().cross(turned(x, first_)).above % 2 == 1;
    int votes = 0;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
        const auto found = axes_[a].cross(turned(x, (first_ + a) % 3));
        votes += found.above % 2 + found.below % 2;
    }
    return votes > 3;
}

int MeshSides::winding(const Vec<3>& x) const {
    return axes_.front().cross(turned(x, first_)).turns;
}

}  // namespace vdbpack
