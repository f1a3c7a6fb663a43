#include "vdbpack/mesh/repair/resurface.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/narrow_band.h"
#include "vdbpack/mesh/edge_table.h"
#include "vdbpack/mesh/repair/marching_cubes.h"
#include "vdbpack/mesh/repair/winding_number.h"
#include "vdbpack/mesh/vertical_line.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <new>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Tree = FloatGrid::TreeType;
using Leaf = Tree::LeafNodeType;
using Accessor = openvdb::tree::ValueAccessor<const Tree>;

constexpr double kHalf = 0.5;
/// Winding numbers this far from 1/2 stay on their side over a leaf's width.
constexpr double kClear = 0.3;
/// Vertices keep this share of an edge away from its ends, so that no triangle is without area.
constexpr double kMargin = 0.01;
/// The lattice is probed for surfaces away from all triangles at about as many points.
constexpr double kCoarsePoints = 3e5;
constexpr int kReach = 1 << 19;  // of indices, 20 bits each in a packed edge

/// An edge of the lattice: its lower end and axis in one number that sorts by place.
using EdgeKey = std::uint64_t;

EdgeKey keyOf(const Coord& p, int axis) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + kReach); };
    return part(p[2]) << 42 | part(p[1]) << 22 | part(p[0]) << 2 | static_cast<std::uint64_t>(axis);
}

/// Where a triangle crosses an edge of the lattice.
struct Crossing {
    EdgeKey edge;
    float at;      ///< share of the edge from its lower end
    float facing;  ///< cosine between the edge and the triangle's normal, without its sign
    bool operator<(const Crossing& other) const {
        return edge != other.edge ? edge < other.edge : at < other.at;
    }
};

/// The place of a vertex between the ends of an edge.
struct Vertex {
    EdgeKey edge;
    Coord lower;
    int axis;
    float at;
    bool bridge;
};

Coord unit(int axis) {
    Coord c(0, 0, 0);
    c[axis] = 1;
    return c;
}

class Surfacer {
public:
    Surfacer(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
             const Callbacks& callbacks)
        : winding_(winding), voxelSize_(voxelSize), callbacks_(callbacks) {
        // Off the round numbers that planes of a mesh like to lie at.
        const Vec<3> center = mesh.bounds().center();
        for (int d = 0; d < 3; ++d)
            origin_[d] =
                center[d] + voxelSize * std::array<double, 3>{0.4142, 0.2361,
                                                              0.3166}[static_cast<std::size_t>(d)];
        double furthest = 0;
        const Box<3> box = mesh.bounds();
        for (int d = 0; d < 3; ++d)
            furthest = std::max({furthest, std::fabs(box.lo[d]), std::fabs(box.hi[d])});
        roundable_ = furthest * 0x1p-23 < 0.2 * kMargin * voxelSize;
        local_ = mesh;
        for (auto& v : local_.vertices) v = (v - origin_) * (1 / voxelSize);
    }

    Resurfaced run() {
        layBand();
        findCrossings();
        tell(0.4, 0);
        evaluate();
        tell(0.6, 0);
        probeElsewhere();
        follow();
        tell(0.8, 0);
        placeVertices();
        tell(0.9, static_cast<double>(vertices_.size()));
        return makeMesh();
    }

private:
    void tell(double fraction, double count) const {
        callbacks_.stopIfCancelled();
        callbacks_.report("repair", fraction, count);
    }
    Vec<3> world(const Vec<3>& p) const { return origin_ + p * voxelSize_; }
    Vec<3> world(const Coord& c) const {
        return world(Vec<3>{
            {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])}});
    }
    static bool isInside(float winding) { return winding >= kHalf; }

    /// Active: all points of cells that hold a triangle, and a few more.
    void layBand() {
        grid_ = unsignedBand({local_, {}, {}, 1}, 1.8f, callbacks_);
        grid_->tree().voxelizeActiveTiles();
    }

    /// Winding numbers of all points of the band.
    ///
    /// Between neighbors that no triangle comes between the winding number changes but slowly,
    /// unless the rim of a hole is near. So the points of a leaf that hang together take that of
    /// one of them where no rim is within a leaf's width, and a clear answer comes out alike twice.
    void evaluate() {
        const std::unordered_set<EdgeKey> rims = leafsNearRims();
        const auto crossed = crossedEdges();
        openvdb::tree::LeafManager<Tree> leafs(grid_->tree());
        leafs.foreach ([&](Leaf& leaf, std::size_t) {
            const Coord corner = leaf.origin();
            if (rims.count(leafKeyOf(corner)) != 0) {
                for (auto value = leaf.beginValueOn(); value; ++value)
                    value.setValue(windingAt(value.getCoord()));
                return;
            }
            const auto found = crossed.find(leafKeyOf(corner));
            const EdgeMasks* walls = found == crossed.end() ? nullptr : &found->second;
            constexpr int kDim = Leaf::DIM;
            std::array<char, Leaf::SIZE> done{};
            std::vector<openvdb::Index> group;
            for (auto value = leaf.beginValueOn(); value; ++value) {
                if (done[value.pos()] != 0) continue;
                group.assign(1, value.pos());
                done[value.pos()] = 1;
                for (std::size_t k = 0; k < group.size(); ++k) {
                    const Coord p = Leaf::offsetToLocalCoord(group[k]);
                    for (int axis = 0; axis < 3; ++axis)
                        for (int way = -1; way <= 1; way += 2) {
                            Coord q = p;
                            q[axis] += way;
                            if (q[axis] < 0 || q[axis] >= kDim) continue;
                            const openvdb::Index at = Leaf::coordToOffset(q);
                            if (done[at] != 0 || !leaf.isValueOn(at)) continue;
                            const openvdb::Index lower = way > 0 ? group[k] : at;
                            if (walls != nullptr && (*walls)[static_cast<std::size_t>(axis)][lower])
                                continue;
                            done[at] = 1;
                            group.push_back(at);
                        }
                }
                const auto evaluated = [&](openvdb::Index at) {
                    return windingAt(leaf.offsetToGlobalCoord(at));
                };
                const float first = evaluated(group.front());
                const float last = group.size() > 1 ? evaluated(group.back()) : first;
                const bool clear = isInside(first) == isInside(last) &&
                                   std::abs(first - kHalf) > kClear &&
                                   std::abs(last - kHalf) > kClear;
                for (const openvdb::Index at : group)
                    leaf.setValueOnly(at, clear ? first : evaluated(at));
            }
        });
    }

    /// By leaf: the edges from its points along each axis that triangles cross.
    using EdgeMasks = std::array<std::bitset<Leaf::SIZE>, 3>;
    std::unordered_map<EdgeKey, EdgeMasks> crossedEdges() const {
        std::unordered_map<EdgeKey, EdgeMasks> crossed;
        for (const Crossing& crossing : crossings_) {
            const auto [lower, axis] = edgeOf(crossing.edge);
            crossed[leafKeyOf(lower)][static_cast<std::size_t>(axis)].set(
                Leaf::coordToOffset(lower));
        }
        return crossed;
    }
    static EdgeKey leafKeyOf(const Coord& p) {
        return keyOf(Coord(p[0] >> 3, p[1] >> 3, p[2] >> 3), 0);
    }

    /// Leafs, by their keys, with an edge in them or next to them at which triangles
    /// do not cancel.
    std::unordered_set<EdgeKey> leafsNearRims() const {
        std::unordered_set<EdgeKey> near;
        const EdgeTable edges(local_);
        edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                          const EdgeTable::Use* last) {
            if (edges.surplus(first, last) == 0) return;
            const Vec<3>& a = local_.vertices[lower];
            const Vec<3> along = local_.vertices[upper] - a;
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
                    near.insert(keyOf(at.offsetBy(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), 0));
            }
        });
        return near;
    }

    float windingAt(const Coord& p) const { return static_cast<float>(winding_(world(p))); }

    /// Sets points active with their winding numbers; those that are already stay.
    void add(std::vector<Coord> points) {
        std::sort(points.begin(), points.end());
        points.erase(std::unique(points.begin(), points.end()), points.end());
        const auto accessor = grid_->getConstAccessor();
        points.erase(std::remove_if(points.begin(), points.end(),
                                    [&](const Coord& p) { return accessor.isValueOn(p); }),
                     points.end());
        std::vector<float> values(points.size());
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 256),
                          [&](const tbb::blocked_range<std::size_t>& range) {
                              for (std::size_t i = range.begin(); i != range.end(); ++i)
                                  values[i] = windingAt(points[i]);
                          });
        auto writer = grid_->getAccessor();
        for (std::size_t i = 0; i < points.size(); ++i) writer.setValueOn(points[i], values[i]);
        fresh_ = std::move(points);
    }

    /// A surface that meets no triangle would be missed by following from them: finds where a
    /// coarse lattice changes sides and adds that place.
    void probeElsewhere() {
        Box<3> box = local_.bounds();
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
        tbb::parallel_for(0, count[2], [&](int k) {
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

    /// Calls `f(lower end, axis)` for edges at `p` with two known ends on different sides.
    template <class F>
    static void changesAt(const Accessor& accessor, const Coord& p, bool bothWays, const F& f) {
        float here = 0, there = 0;
        if (!accessor.probeValue(p, here)) return;
        for (int axis = 0; axis < 3; ++axis) {
            const Coord q = p + unit(axis);
            if (accessor.probeValue(q, there) && isInside(here) != isInside(there)) f(p, axis);
            const Coord o = p - unit(axis);
            if (bothWays && accessor.probeValue(o, there) && isInside(here) != isInside(there))
                f(o, axis);
        }
    }

    /// Appends the unknown corners of the four cells around an edge.
    static void cornersAround(const Accessor& accessor, const Coord& lower, int axis,
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

    /// Adds points until every cell that the surface passes through has eight known corners.
    void follow() {
        tbb::enumerable_thread_specific<std::vector<Coord>> lists;
        {
            const openvdb::tree::LeafManager<const Tree> leafs(grid_->constTree());
            tbb::parallel_for(leafs.leafRange(), [&](const auto& range) {
                const Accessor accessor(grid_->constTree());
                auto& missing = lists.local();
                for (auto leaf = range.begin(); leaf; ++leaf)
                    for (auto value = leaf->beginValueOn(); value; ++value)
                        changesAt(accessor, value.getCoord(), false, [&](const Coord& p, int axis) {
                            cornersAround(accessor, p, axis, missing);
                        });
            });
        }
        std::vector<Coord> missing;
        for (auto& list : lists) missing.insert(missing.end(), list.begin(), list.end());
        while (!missing.empty()) {
            callbacks_.stopIfCancelled();
            add(std::move(missing));
            missing.clear();
            const Accessor accessor(grid_->constTree());
            for (const Coord& p : fresh_)
                changesAt(accessor, p, true, [&](const Coord& lower, int axis) {
                    cornersAround(accessor, lower, axis, missing);
                });
        }
    }

    /// Where triangles cross edges of the lattice, sorted.
    void findCrossings() {
        tbb::enumerable_thread_specific<std::vector<Crossing>> lists;
        for (int axis = 0; axis < 3; ++axis) {
            // Cyclic exchange that brings the axis to z (vertical_line.h).
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            TriangleMesh turned = local_;
            for (auto& p : turned.vertices) p = Vec<3>{{p[u], p[v], p[axis]}};
            tbb::parallel_for(
                tbb::blocked_range<std::size_t>(0, turned.triangles.size(), 512),
                [&](const tbb::blocked_range<std::size_t>& range) {
                    auto& list = lists.local();
                    for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        const auto& t = turned.triangles[i];
                        Box<3> box;
                        for (const std::uint32_t k : t) box.add(turned.vertices[k]);
                        const Vec<3>& a = turned.vertices[t[0]];
                        const Vec<3> n =
                            cross(turned.vertices[t[1]] - a, turned.vertices[t[2]] - a);
                        if (n[2] == 0) continue;
                        const auto facing = static_cast<float>(std::abs(n[2]) / length(n));
                        for (double y = std::ceil(box.lo[1]); y <= box.hi[1]; ++y)
                            for (double x = std::ceil(box.lo[0]); x <= box.hi[0]; ++x) {
                                if (!coversLine(turned, t, {{x, y, 0}})) continue;
                                const double z = std::clamp(
                                    a[2] - (n[0] * (x - a[0]) + n[1] * (y - a[1])) / n[2],
                                    box.lo[2], box.hi[2]);
                                Coord lower;
                                lower[u] = static_cast<int>(x);
                                lower[v] = static_cast<int>(y);
                                lower[axis] = static_cast<int>(std::floor(z));
                                list.push_back({keyOf(lower, axis),
                                                static_cast<float>(z - std::floor(z)), facing});
                            }
                    }
                });
        }
        for (const auto& list : lists)
            crossings_.insert(crossings_.end(), list.begin(), list.end());
        tbb::parallel_sort(crossings_.begin(), crossings_.end());
    }

    double windingOn(const Coord& lower, int axis, double at) const {
        Vec<3> p{{static_cast<double>(lower[0]), static_cast<double>(lower[1]),
                  static_cast<double>(lower[2])}};
        p[axis] += at;
        return winding_(world(p));
    }

    /// The place on an edge whose ends lie on different sides.
    Vertex vertexOn(const Coord& lower, int axis, bool lowerInside) const {
        Vertex vertex{keyOf(lower, axis), lower, axis, 0.5f, false};
        const auto [first, last] =
            std::equal_range(crossings_.begin(), crossings_.end(), Crossing{vertex.edge, 0, 0},
                             [](const Crossing& a, const Crossing& b) { return a.edge < b.edge; });
        double at = 0.5;
        if (last - first == 1) {
            at = first->at;
        } else if (last != first) {
            // The first after which the other side is reached.
            const auto* crossing = &*first;
            for (; crossing + 1 != &*first + (last - first); ++crossing) {
                const double middle = 0.5 * (crossing[0].at + crossing[1].at);
                if ((windingOn(lower, axis, middle) >= kHalf) != lowerInside) break;
            }
            at = crossing->at;
        } else {
            vertex.bridge = true;
            double low = 0, high = 1;
            for (int i = 0; i < 8; ++i) {
                at = 0.5 * (low + high);
                ((windingOn(lower, axis, at) >= kHalf) == lowerInside ? low : high) = at;
            }
        }
        vertex.at = static_cast<float>(std::clamp(at, kMargin, 1 - kMargin));
        return vertex;
    }

    void placeVertices() {
        tbb::enumerable_thread_specific<std::vector<Vertex>> lists;
        const openvdb::tree::LeafManager<const Tree> leafs(grid_->constTree());
        tbb::parallel_for(leafs.leafRange(), [&](const auto& range) {
            const Accessor accessor(grid_->constTree());
            auto& list = lists.local();
            for (auto leaf = range.begin(); leaf; ++leaf)
                for (auto value = leaf->beginValueOn(); value; ++value)
                    changesAt(accessor, value.getCoord(), false, [&](const Coord& p, int axis) {
                        list.push_back(vertexOn(p, axis, isInside(*value)));
                    });
        });
        for (const auto& list : lists) vertices_.insert(vertices_.end(), list.begin(), list.end());
        tbb::parallel_sort(vertices_.begin(), vertices_.end(),
                           [](const Vertex& a, const Vertex& b) { return a.edge < b.edge; });
        if (vertices_.size() >= static_cast<std::size_t>(1) << 31)
            throw ResourceError(fmt::format(
                "the repaired surface would take {} vertices; give a larger --repair-voxel",
                vertices_.size()));
        measureThin();
    }

    /// Walls that an edge passes through with both ends on one side.
    void measureThin() {
        // In parts of fixed size, so that the sum is the same for any number of threads.
        constexpr std::size_t kPart = 4096;
        std::vector<double> sums(crossings_.size() / kPart + 1, 0);
        tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t part) {
            const Accessor accessor(grid_->constTree());
            const std::size_t end = std::min(crossings_.size(), (part + 1) * kPart);
            for (std::size_t i = part * kPart; i < end; ++i) {
                if (i + 1 >= crossings_.size() || crossings_[i].edge != crossings_[i + 1].edge ||
                    crossings_[i + 1].at - crossings_[i].at < 1e-4f)
                    continue;
                const auto [lower, axis] = edgeOf(crossings_[i].edge);
                const bool low = isInside(accessor.getValue(lower));
                const bool high = isInside(accessor.getValue(lower + unit(axis)));
                const double middle = 0.5 * (crossings_[i].at + crossings_[i + 1].at);
                // An edge stands for a square of the plane across it; over the three axes the
                // squares of the cosines add up to one.
                if (low == high && (windingOn(lower, axis, middle) >= kHalf) != low)
                    sums[part] += static_cast<double>(crossings_[i].facing);
            }
        });
        for (const double sum : sums) thinArea_ += sum * voxelSize_ * voxelSize_;
    }

    static std::pair<Coord, int> edgeOf(EdgeKey key) {
        constexpr std::uint64_t kMask = (1u << 20) - 1;
        const auto part = [&](int shift) {
            return static_cast<int>(key >> shift & kMask) - kReach;
        };
        return {Coord(part(2), part(22), part(42)), static_cast<int>(key & 3)};
    }

    Resurfaced makeMesh() {
        // Cells that have a vertex on one of their edges, by their lowest corners.
        std::vector<EdgeKey> cells;
        cells.reserve(vertices_.size() * 4);
        for (const Vertex& v : vertices_) {
            const int a = (v.axis + 1) % 3, b = (v.axis + 2) % 3;
            for (int k = 0; k < 4; ++k) {
                Coord c = v.lower;
                c[a] -= k & 1;
                c[b] -= k >> 1;
                cells.push_back(keyOf(c, 0));
            }
        }
        tbb::parallel_sort(cells.begin(), cells.end());
        cells.erase(std::unique(cells.begin(), cells.end()), cells.end());

        static const auto kLoops = makeCubeLoops();
        struct Part {
            std::vector<std::array<std::uint32_t, 3>> triangles;  // centers: kCenter + number
            std::vector<Vec<3>> centers;                          // in voxels
        };
        constexpr std::uint32_t kCenter = 1u << 31;
        constexpr std::size_t kChunk = 4096;
        std::vector<Part> parts((cells.size() + kChunk - 1) / kChunk);
        tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t chunk) {
            const Accessor accessor(grid_->constTree());
            Part& part = parts[chunk];
            const std::size_t end = std::min(cells.size(), (chunk + 1) * kChunk);
            for (std::size_t i = chunk * kChunk; i < end; ++i) {
                const Coord cell = edgeOf(cells[i]).first;
                std::size_t inside = 0;
                for (int c = 0; c < 8; ++c)
                    if (isInside(accessor.getValue(cell.offsetBy(c & 1, c >> 1 & 1, c >> 2))))
                        inside |= std::size_t{1} << c;
                for (const auto& loop : kLoops[inside]) addLoop(cell, loop, part, kCenter);
            }
        });

        Resurfaced result;
        TriangleMesh& mesh = result.mesh;
        std::size_t bridges = 0;
        for (const Vertex& v : vertices_) {
            mesh.vertices.push_back(rounded(world(placeOf(v))));
            bridges += v.bridge;
        }
        for (const Part& part : parts) {
            const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
            for (const Vec<3>& center : part.centers)
                mesh.vertices.push_back(rounded(world(center)));
            for (auto t : part.triangles) {
                for (auto& v : t)
                    if (v >= kCenter) v = first + (v - kCenter);
                mesh.triangles.push_back(t);
            }
        }
        result.thinArea = thinArea_;
        result.bridgedShare = vertices_.empty() ? 0
                                                : static_cast<double>(bridges) /
                                                      static_cast<double>(vertices_.size());
        return result;
    }

    /// To the nearest numbers that a binary .stl holds, so that the surface can be read back as it
    /// is; not far from zero, where they lie too far apart for the lattice.
    Vec<3> rounded(const Vec<3>& p) const {
        if (!roundable_) return p;
        Vec<3> q;
        for (int d = 0; d < 3; ++d) q[d] = static_cast<double>(static_cast<float>(p[d]));
        return q;
    }

    static Vec<3> placeOf(const Vertex& v) {
        Vec<3> p{{static_cast<double>(v.lower[0]), static_cast<double>(v.lower[1]),
                  static_cast<double>(v.lower[2])}};
        p[v.axis] += v.at;
        return p;
    }

    /// Triangles of one loop in a cell: a fan from a vertex whose diagonals run through the cell,
    /// as one in a face could be an edge of the next cell too; else about the middle.
    template <class Part>
    void addLoop(const Coord& cell, const std::vector<std::uint8_t>& loop, Part& part,
                 std::uint32_t centerMark) const {
        std::array<std::uint32_t, 12> ids{};
        const std::size_t n = loop.size();
        for (std::size_t k = 0; k < n; ++k) {
            const CubeEdge edge = cubeEdge(loop[k]);
            const Coord lower =
                cell.offsetBy(edge.corner & 1, edge.corner >> 1 & 1, edge.corner >> 2);
            const EdgeKey key = keyOf(lower, edge.axis);
            const auto at =
                std::lower_bound(vertices_.begin(), vertices_.end(), key,
                                 [](const Vertex& v, EdgeKey wanted) { return v.edge < wanted; });
            ids[k] = static_cast<std::uint32_t>(at - vertices_.begin());
        }
        for (std::size_t apex = 0; apex < n; ++apex) {
            bool free = true;
            for (std::size_t k = 2; k + 1 < n && free; ++k)
                free = !shareFace(loop[apex], loop[(apex + k) % n]);
            if (!free) continue;
            for (std::size_t k = 1; k + 1 < n; ++k)
                part.triangles.push_back({ids[apex], ids[(apex + k) % n], ids[(apex + k + 1) % n]});
            return;
        }
        Vec<3> middle;
        for (std::size_t k = 0; k < n; ++k) middle += placeOf(vertices_[ids[k]]);
        const auto center = static_cast<std::uint32_t>(centerMark + part.centers.size());
        part.centers.push_back(middle * (1.0 / static_cast<double>(n)));
        for (std::size_t k = 0; k < n; ++k)
            part.triangles.push_back({ids[k], ids[(k + 1) % n], center});
    }

    const WindingNumber& winding_;
    double voxelSize_;
    const Callbacks& callbacks_;
    Vec<3> origin_;
    TriangleMesh local_;  // in voxels about origin_
    FloatGrid::Ptr grid_;
    std::vector<Coord> fresh_;
    std::vector<Crossing> crossings_;
    std::vector<Vertex> vertices_;
    double thinArea_ = 0;
    bool roundable_ = false;
};

}  // namespace

Resurfaced resurface(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
                     const Callbacks& callbacks) {
    const Vec<3> size = mesh.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    if (!(longest / voxelSize < kReach - 16))
        throw ResourceError(fmt::format(
            "voxels of {:.4g} mm are too many along {:.4g} mm; give a larger --repair-voxel",
            voxelSize, longest));
    try {
        return Surfacer(mesh, winding, voxelSize, callbacks).run();
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "not enough memory to repair a surface in voxels of {:.4g} mm; give a larger "
            "--repair-voxel",
            voxelSize));
    }
}

}  // namespace vdbpack
