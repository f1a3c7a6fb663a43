#include "vdbpack/field/winding_lattice.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/sealed_band.h"
#include "vdbpack/mesh/edge_table.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Tree = FloatGrid::TreeType;
using Leaf = Tree::LeafNodeType;
using Accessor = openvdb::tree::ValueAccessor<const Tree>;

/// Winding numbers this far from 1/2 stay on their side over a leaf's width.
constexpr double kClear = 0.3;
/// Width of the band of known points, voxels: all corners of cells that contain a part of a
/// triangle, and a few more.
constexpr float kBandVoxels = 1.8f;
/// The lattice is probed for surfaces away from all triangles at about as many points.
constexpr double kCoarsePoints = 3e5;

VoxelIndex indexOf(const Coord& p) {
    return {p[0], p[1], p[2]};
}

/// Of the leaf that a point belongs to.
EdgeKey leafKeyOf(const Coord& p) {
    return edgeKey({p[0] >> 3, p[1] >> 3, p[2] >> 3}, 0);
}

/// By leaf: the edges from its points along each axis that triangles cross.
using EdgeMasks = std::array<std::bitset<Leaf::SIZE>, 3>;
std::unordered_map<EdgeKey, EdgeMasks> crossedByLeaf(const std::vector<EdgeKey>& crossed) {
    std::unordered_map<EdgeKey, EdgeMasks> masks;
    for (const EdgeKey key : crossed) {
        const auto [lower, axis] = edgeOf(key);
        const Coord p(lower[0], lower[1], lower[2]);
        masks[leafKeyOf(p)][static_cast<std::size_t>(axis)].set(Leaf::coordToOffset(p));
    }
    return masks;
}

/// Leaves, by their keys, with an edge in them or next to them at which triangles do not cancel.
std::unordered_set<EdgeKey> leafsNearRims(const TriangleMesh& mesh) {
    std::unordered_set<EdgeKey> near;
    const EdgeTable edges(mesh);
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        if (edges.surplus(first, last) == 0) return;
        const Vec<3>& a = mesh.vertices[lower];
        const Vec<3> along = mesh.vertices[upper] - a;
        const int steps = static_cast<int>(length(along) / 8) + 1;
        Coord before = Coord::max();
        for (int k = 0; k <= steps; ++k) {
            const Vec<3> p = a + along * (static_cast<double>(k) / steps);
            const Coord at(static_cast<int>(std::floor(p[0] / 8)),
                           static_cast<int>(std::floor(p[1] / 8)),
                           static_cast<int>(std::floor(p[2] / 8)));
            if (at == before) continue;
            before = at;
            for (int i = 0; i < 27; ++i)
                near.insert(edgeKey(indexOf(at.offsetBy(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)), 0));
        }
    });
    return near;
}

Coord unit(int axis) {
    Coord c(0, 0, 0);
    c[axis] = 1;
    return c;
}

/// Points of a leaf that are connected by edges that no triangle crosses.
class LeafGroups {
public:
    /// @param walls  crossed edges; null: none.
    LeafGroups(const Leaf& leaf, const EdgeMasks* walls) : leaf_(leaf), walls_(walls) {}

    bool isDone(openvdb::Index point) const { return done_[point]; }
    /// The group of an active point that is not done yet, in the order in which it is found.
    const std::vector<openvdb::Index>& take(openvdb::Index point) {
        group_.assign(1, point);
        done_[point] = true;
        for (std::size_t k = 0; k < group_.size(); ++k) {
            const Coord p = Leaf::offsetToLocalCoord(group_[k]);
            for (int axis = 0; axis < 3; ++axis)
                for (int way = -1; way <= 1; way += 2) visit(group_[k], p, axis, way);
        }
        return group_;
    }

private:
    void visit(openvdb::Index from, const Coord& p, int axis, int way) {
        Coord q = p;
        q[axis] += way;
        if (q[axis] < 0 || q[axis] >= static_cast<int>(Leaf::DIM)) return;
        const openvdb::Index at = Leaf::coordToOffset(q);
        if (done_[at] || !leaf_.isValueOn(at)) return;
        const openvdb::Index lower = way > 0 ? from : at;
        if (walls_ != nullptr && (*walls_)[static_cast<std::size_t>(axis)][lower]) return;
        done_[at] = true;
        group_.push_back(at);
    }

    const Leaf& leaf_;
    const EdgeMasks* walls_;
    std::bitset<Leaf::SIZE> done_;
    std::vector<openvdb::Index> group_;
};

/// Calls `f(lower end, axis)` for edges at `p` with two known ends on different sides.
template <class F>
void changesAt(const Accessor& accessor, const Coord& p, bool bothWays, const F& f) {
    float here = 0, there = 0;
    if (!accessor.probeValue(p, here)) return;
    for (int axis = 0; axis < 3; ++axis) {
        const Coord q = p + unit(axis);
        if (accessor.probeValue(q, there) &&
            WindingLattice::isInside(here) != WindingLattice::isInside(there))
            f(p, axis);
        const Coord o = p - unit(axis);
        if (bothWays && accessor.probeValue(o, there) &&
            WindingLattice::isInside(here) != WindingLattice::isInside(there))
            f(o, axis);
    }
}

/// Appends the unknown corners of the four cells around an edge.
void cornersAround(const Accessor& accessor, const Coord& lower, int axis,
                   std::vector<Coord>& missing) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int a = -1; a <= 1; ++a)
        for (int b = -1; b <= 1; ++b)
            for (int end = 0; end < 2; ++end) {
                Coord c = lower;
                c[u] += a;
                c[v] += b;
                c[axis] += end;
                if (!accessor.isValueOn(c)) missing.push_back(c);
            }
}

}  // namespace

struct WindingLattice::Impl {
    const TriangleMesh& mesh;
    Winding winding;
    const Callbacks& callbacks;
    FloatGrid::Ptr grid;
    std::vector<Coord> fresh;  ///< points added last

    float windingAt(const Coord& p) const {
        return static_cast<float>(winding(pointOf(indexOf(p))));
    }
    void evaluate(const std::vector<EdgeKey>& crossed);
    void evaluateGroup(Leaf& leaf, const std::vector<openvdb::Index>& group) const;
    void add(std::vector<Coord> points);
    void probeElsewhere();
    template <class T, class Visit>
    std::vector<T> collectChanges(const Visit& visit) const;
    void follow();
};

/// Winding numbers of all points of the band.
///
/// Between neighbors with no triangle between them the winding number changes slowly, unless the
/// rim of a hole is near. So connected points of a leaf take that of one of them where no rim is
/// within a leaf's width and a clear result is the same at two of them.
void WindingLattice::Impl::evaluate(const std::vector<EdgeKey>& crossed) {
    const std::unordered_set<EdgeKey> rims = leafsNearRims(mesh);
    const auto crossedEdges = crossedByLeaf(crossed);
    openvdb::tree::LeafManager<Tree> leafs(grid->tree());
    leafs.foreach ([&](Leaf& leaf, std::size_t) {
        const EdgeKey key = leafKeyOf(leaf.origin());
        if (rims.count(key) != 0) {
            for (auto value = leaf.beginValueOn(); value; ++value)
                value.setValue(windingAt(value.getCoord()));
            return;
        }
        const auto found = crossedEdges.find(key);
        LeafGroups groups(leaf, found == crossedEdges.end() ? nullptr : &found->second);
        for (auto value = leaf.beginValueOn(); value; ++value)
            if (!groups.isDone(value.pos())) evaluateGroup(leaf, groups.take(value.pos()));
    });
}

void WindingLattice::Impl::evaluateGroup(Leaf& leaf,
                                         const std::vector<openvdb::Index>& group) const {
    const auto evaluated = [&](openvdb::Index at) {
        return windingAt(leaf.offsetToGlobalCoord(at));
    };
    const float first = evaluated(group.front());
    const float last = group.size() > 1 ? evaluated(group.back()) : first;
    const bool clear = isInside(first) == isInside(last) && std::abs(first - 0.5) > kClear &&
                       std::abs(last - 0.5) > kClear;
    for (const openvdb::Index at : group) leaf.setValueOnly(at, clear ? first : evaluated(at));
}

/// Sets points active with their winding numbers; those that are already stay.
void WindingLattice::Impl::add(std::vector<Coord> points) {
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    const auto accessor = grid->getConstAccessor();
    points.erase(std::remove_if(points.begin(), points.end(),
                                [&](const Coord& p) { return accessor.isValueOn(p); }),
                 points.end());
    std::vector<float> values(points.size());
    parallelFor(IndexRange(0, points.size(), 256), [&](const IndexRange& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) values[i] = windingAt(points[i]);
    });
    auto writer = grid->getAccessor();
    for (std::size_t i = 0; i < points.size(); ++i) writer.setValueOn(points[i], values[i]);
    fresh = std::move(points);
}

/// A surface that meets no triangle would be missed by following from them: finds where a
/// coarse lattice changes sides and adds that place.
void WindingLattice::Impl::probeElsewhere() {
    Box<3> box = mesh.bounds();
    const Vec<3> size = box.size();
    const double step =
        std::max(4.0, std::cbrt((size[0] + 8) * (size[1] + 8) * (size[2] + 8) / kCoarsePoints));
    int count[3];
    for (int d = 0; d < 3; ++d) count[d] = static_cast<int>(std::ceil(size[d] / step)) + 3;
    const auto place = [&](int i, int j, int k) {
        return Coord(static_cast<int>(std::floor(box.lo[0] + step * (i - 1))),
                     static_cast<int>(std::floor(box.lo[1] + step * (j - 1))),
                     static_cast<int>(std::floor(box.lo[2] + step * (k - 1))));
    };
    const auto n0 = static_cast<std::size_t>(count[0]), n1 = static_cast<std::size_t>(count[1]);
    const auto index = [&](int i, int j, int k) {
        return (static_cast<std::size_t>(k) * n1 + static_cast<std::size_t>(j)) * n0 +
               static_cast<std::size_t>(i);
    };
    std::vector<char> inside(n0 * n1 * static_cast<std::size_t>(count[2]));
    parallelFor(0, count[2], [&](int k) {
        for (int j = 0; j < count[1]; ++j)
            for (int i = 0; i < count[0]; ++i)
                inside[index(i, j, k)] = isInside(windingAt(place(i, j, k)));
    });
    std::vector<Coord> found;
    const auto bisect = [&](Coord a, Coord b, bool insideA) {
        // The two differ along one axis.
        while (std::max({b[0] - a[0], b[1] - a[1], b[2] - a[2]}) > 1) {
            const Coord m((a[0] + b[0]) >> 1, (a[1] + b[1]) >> 1, (a[2] + b[2]) >> 1);
            if (isInside(windingAt(m)) == insideA)
                a = m;
            else
                b = m;
        }
        found.push_back(a);
        found.push_back(b);
    };
    for (int k = 0; k < count[2]; ++k)
        for (int j = 0; j < count[1]; ++j)
            for (int i = 0; i < count[0]; ++i) {
                const bool here = inside[index(i, j, k)] != 0;
                const Coord at = place(i, j, k);
                if (i + 1 < count[0] && here != (inside[index(i + 1, j, k)] != 0))
                    bisect(at, place(i + 1, j, k), here);
                if (j + 1 < count[1] && here != (inside[index(i, j + 1, k)] != 0))
                    bisect(at, place(i, j + 1, k), here);
                if (k + 1 < count[2] && here != (inside[index(i, j, k + 1)] != 0))
                    bisect(at, place(i, j, k + 1), here);
            }
    add(std::move(found));
}

/// Calls `visit(accessor, list of this thread, lower end, axis)` in parallel for the edges of the
/// lattice with two known ends on different sides. @return the lists of all threads
template <class T, class Visit>
std::vector<T> WindingLattice::Impl::collectChanges(const Visit& visit) const {
    PerThread<std::vector<T>> lists;
    const openvdb::tree::LeafManager<const Tree> leafs(grid->constTree());
    tbb::parallel_for(leafs.leafRange(), [&](const auto& range) {
        const Accessor accessor(grid->constTree());
        auto& list = lists.local();
        for (auto leaf = range.begin(); leaf; ++leaf)
            for (auto value = leaf->beginValueOn(); value; ++value)
                changesAt(accessor, value.getCoord(), false,
                          [&](const Coord& p, int axis) { visit(accessor, list, p, axis); });
    });
    std::vector<T> all;
    for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

void WindingLattice::Impl::follow() {
    auto missing =
        collectChanges<Coord>([](const Accessor& accessor, std::vector<Coord>& list, const Coord& p,
                                 int axis) { cornersAround(accessor, p, axis, list); });
    while (!missing.empty()) {
        callbacks.stopIfCancelled();
        add(std::move(missing));
        missing.clear();
        const Accessor accessor(grid->constTree());
        for (const Coord& p : fresh)
            changesAt(accessor, p, true, [&](const Coord& lower, int axis) {
                cornersAround(accessor, lower, axis, missing);
            });
    }
}

WindingLattice::WindingLattice(const TriangleMesh& mesh, const std::vector<EdgeKey>& crossed,
                               Winding winding, const Callbacks& callbacks)
    : impl_(std::make_unique<Impl>(Impl{mesh, std::move(winding), callbacks, {}, {}})) {
    impl_->grid = unsignedBand({mesh, {}, 1}, kBandVoxels, callbacks);
    impl_->grid->tree().voxelizeActiveTiles();
    impl_->evaluate(crossed);
}
WindingLattice::~WindingLattice() = default;

void WindingLattice::followSurface() {
    impl_->probeElsewhere();
    impl_->follow();
}

std::vector<WindingLattice::Change> WindingLattice::changes() const {
    auto changes = impl_->collectChanges<Change>(
        [](const Accessor& accessor, std::vector<Change>& list, const Coord& p, int axis) {
            list.push_back({edgeKey(indexOf(p), axis), isInside(accessor.getValue(p))});
        });
    tbb::parallel_sort(changes.begin(), changes.end(),
                       [](const Change& a, const Change& b) { return a.edge < b.edge; });
    return changes;
}

struct WindingLattice::Reader::Impl {
    Accessor accessor;
};

WindingLattice::Reader::Reader(const WindingLattice& lattice)
    : impl_(std::make_unique<Impl>(Impl{Accessor(lattice.impl_->grid->constTree())})) {}
WindingLattice::Reader::~Reader() = default;

bool WindingLattice::Reader::isInside(const VoxelIndex& p) {
    return WindingLattice::isInside(impl_->accessor.getValue(Coord(p[0], p[1], p[2])));
}

}  // namespace vdbpack
