#include "vdbpack/field/band/band_features.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/lanes.h"
#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <unordered_map>
#include <utility>

namespace vdbpack {

namespace {

/// Normals that differ by less are of one plane.
constexpr double kSame = 1e-9;
/// Cones of vertices with more edges are not computed: all directions count.
constexpr std::size_t kMostEdges = 24;

/// The triangles at each vertex, in any order.
class Fans {
public:
    explicit Fans(const BandMesh& mesh) {
        const auto& triangles = *mesh.triangles;
        std::vector<std::atomic<std::uint32_t>> next(mesh.vertices.size());
        const auto forEachCorner = [&](const auto& visit) {
            forAll(triangles.size(), [&](std::size_t i) {
                for (const std::size_t v : triangles[i]) visit(next[v], i);
            });
        };
        forEachCorner([](std::atomic<std::uint32_t>& count, std::size_t) {
            count.fetch_add(1, std::memory_order_relaxed);
        });
        triangle_.resize(
            firstPositions(next, start_, "corners of triangles", "use a mesh of fewer triangles"));
        forEachCorner([&](std::atomic<std::uint32_t>& place, std::size_t i) {
            triangle_[place.fetch_add(1, std::memory_order_relaxed)] =
                static_cast<std::uint32_t>(i);
        });
    }

    /// The triangles at a vertex.
    std::uint32_t* first(std::size_t v) { return triangle_.data() + start_[v]; }
    std::uint32_t* last(std::size_t v) { return triangle_.data() + start_[v + 1]; }

private:
    std::vector<std::uint32_t> start_, triangle_;
};

/// A triangle at the vertex that is worked on.
struct Corner {
    Vec<3> normal;
    BandWidths widths;
};

/// An edge from the vertex that is worked on, and its first two triangles.
struct Uses {
    std::uint32_t other;  ///< the vertex at the other end
    std::uint32_t count;  ///< triangles at the edge
    std::array<std::uint32_t, 2> corner;
    std::array<bool, 2> forward;  ///< the triangle runs from this vertex to the other
    float widest;                 ///< of the bands at all triangles
};

/// The side to which the wedge between the triangles at an edge opens: that of their normals, the
/// other, ... Bits, so that those of a vertex's edges can be collected.
enum Bend : unsigned { flat = 0, above = 1, below = 2, unknown = 4 };

float reachOf(unsigned bends, const BandWidths& widths) {
    return bends == Bend::above   ? widths.above
           : bends == Bend::below ? widths.below
                                  : widths.larger();
}

Vec<3> unit(const Vec<3>& v) {
    const double l = length(v);
    return l > 0 ? v * (1 / l) : Vec<3>{};
}

/// Works on one vertex at a time.
class Neighborhood {
public:
    Neighborhood(const BandMesh& mesh, const FeatureVisits& visits)
        : mesh_(mesh), visits_(visits) {}

    /// Adds `v`, if it matters, and its edges to higher vertices.
    /// @param first, last  the triangles at `v`.
    void add(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last,
             BandFeatures& features) {
        gather(v, first, last);
        unsigned bends = Bend::flat;
        for (const Uses& uses : edges_) {
            BandEdge edge{v, uses.other, uses.widest, {}, {}};
            const Bend bend = wedgeOf(uses, edge);
            bends |= bend;
            if (bend == Bend::flat || uses.other < v) continue;
            if (bend != Bend::unknown)
                edge.reach = std::max(reachOf(bend, corners_[uses.corner[0]].widths),
                                      reachOf(bend, corners_[uses.corner[1]].widths));
            if (!visits_.edge(edge)) features.edges.add(edge);
        }
        if (bends == Bend::flat) {
            if (isFlat()) return;
            bends = Bend::above | Bend::below;
        }
        if (addConesOfNormals(v, bends, features.vertices)) return;
        BandVertex vertex{v, 0, {}, -1};
        for (const Corner& corner : corners_)
            vertex.reach = std::max(vertex.reach, reachOf(bends, corner.widths));
        if (polarCone(vertex) && !visits_.vertex(vertex)) features.vertices.add(vertex);
    }

private:
    /// Without triangles with two equal corners, which are no more than an edge of others.
    void gather(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last) {
        corners_.clear();
        edges_.clear();
        if (numbered_ > 0) numberOf_.clear();
        numbered_ = 0;
        for (; first != last; ++first) {
            const auto& t = (*mesh_.triangles)[*first];
            if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
            corners_.push_back({mesh_.normal(*first), mesh_.widths(*first)});
            const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
            addUse(t[(k + 1) % 3], true);
            addUse(t[(k + 2) % 3], false);
        }
    }
    /// Adds a use of an edge by the last corner.
    void addUse(std::uint32_t other, bool forward) {
        const auto corner = static_cast<std::uint32_t>(corners_.size() - 1);
        const float widest = corners_.back().widths.larger();
        if (Uses* const uses = usesOf(other)) {
            if (uses->count == 1) {
                uses->corner[1] = corner;
                uses->forward[1] = forward;
            }
            ++uses->count;
            uses->widest = std::max(uses->widest, widest);
            return;
        }
        Uses uses;
        uses.other = other;
        uses.count = 1;
        uses.corner[0] = corner;
        uses.forward[0] = forward;
        uses.widest = widest;
        edges_.push_back(uses);
    }

    /// The edge to `other`, if there is one yet. A fan of thousands of triangles takes a table.
    Uses* usesOf(std::uint32_t other) {
        if (edges_.size() < kMostEdges) {
            const auto at = std::find_if(edges_.begin(), edges_.end(),
                                         [&](const Uses& uses) { return uses.other == other; });
            return at == edges_.end() ? nullptr : &*at;
        }
        for (; numbered_ < edges_.size(); ++numbered_)
            numberOf_[edges_[numbered_].other] = numbered_;
        const auto at = numberOf_.find(other);
        return at == numberOf_.end() ? nullptr : &edges_[at->second];
    }

    /// How the triangles at an edge meet; sets the edge's wedge.
    Bend wedgeOf(const Uses& uses, BandEdge& edge) const {
        if (uses.count != 2) return Bend::unknown;
        const bool consistent = uses.forward[0] != uses.forward[1];
        const std::size_t ahead = uses.forward[0] ? 0 : 1;
        // A triangle that faces the other way than its neighbor is turned over.
        const Vec<3>& forward = corners_[uses.corner[ahead]].normal;
        const Vec<3> backward = corners_[uses.corner[1 - ahead]].normal * (consistent ? 1.0 : -1.0);
        if (!(squaredLength(forward) > 0 && squaredLength(backward) > 0)) return Bend::unknown;
        // The wedge is as wide as the normals differ.
        const double opening = squaredLength(forward - backward);
        if (!(opening > kFlat * kFlat)) return Bend::flat;
        const Vec<3> along = mesh_.vertices[edge.b] - mesh_.vertices[edge.a];
        const double turn = dot(along, cross(forward, backward));
        edge.n0 = turn > 0 ? forward : backward * -1.0;
        edge.n1 = turn > 0 ? backward : forward * -1.0;
        const bool foldedBack = turn * turn < 1e-6 * opening * squaredLength(along);
        return foldedBack || !consistent ? Bend::unknown : turn > 0 ? Bend::above : Bend::below;
    }

    /// Whether all normals count as one.
    bool isFlat() const {
        return std::all_of(corners_.begin(), corners_.end(), [&](const Corner& corner) {
            return squaredLength(corner.normal - corners_.front().normal) <= kFlat * kFlat;
        });
    }

    /// @return false where rays span a right angle: they no longer bound a convex cone.
    bool setCone(const std::vector<Vec<3>>& rays, BandVertex& vertex) const {
        Vec<3> sum{};
        for (const auto& r : rays) sum = sum + r;
        const Vec<3> axis = unit(sum);
        double cosine = 1;
        for (const auto& r : rays) cosine = std::min(cosine, dot(r, axis));
        if (!(cosine > 0.01)) return false;
        for (int i = 0; i < 3; ++i)
            vertex.axis[static_cast<std::size_t>(i)] = static_cast<float>(axis[i]);
        vertex.cosine = static_cast<float>(cosine - 1e-6);
        return true;
    }

    /// The points that are nearest to a vertex lie in the cone about the mean of its normals that
    /// holds all of these, or in the opposite cone: if all edges bend the same way, in one of them,
    /// where the normals are its extreme rays. @return false if the vertex is not dealt with.
    bool addConesOfNormals(std::uint32_t v, unsigned bends, BlockList<BandVertex>& vertices) {
        if ((bends & Bend::unknown) != 0) return false;
        BandVertex above{v, 0, {}, -1}, below = above;
        rays_.clear();
        for (const Corner& corner : corners_) {
            rays_.push_back(corner.normal);
            above.reach = std::max(above.reach, corner.widths.above);
            below.reach = std::max(below.reach, corner.widths.below);
        }
        if (!setCone(rays_, above)) return false;
        below.cosine = above.cosine;
        for (std::size_t i = 0; i < 3; ++i) below.axis[i] = -above.axis[i];
        const bool done = ((bends & Bend::above) == 0 || visits_.vertex(above)) &&
                          ((bends & Bend::below) == 0 || visits_.vertex(below));
        if (done) return true;
        if (bends == (Bend::above | Bend::below)) return false;
        if (!isWithinStraightEdge()) vertices.add(bends == Bend::above ? above : below);
        return true;
    }
    /// Whether `rays_` are the normals of two planes.
    bool isWithinStraightEdge() const {
        const auto same = [](const Vec<3>& one, const Vec<3>& other) {
            return squaredLength(one - other) < kSame * kSame;
        };
        const auto other = std::find_if(rays_.begin(), rays_.end(), [&](const Vec<3>& ray) {
            return !same(ray, rays_.front());
        });
        return std::all_of(other, rays_.end(), [&](const Vec<3>& ray) {
            return same(ray, rays_.front()) || same(ray, *other);
        });
    }

    /// The cone of the points whose product with no edge is positive. @return whether there are
    /// any.
    bool polarCone(BandVertex& vertex) {
        const std::size_t count = edges_.size();
        if (count > kMostEdges) return true;
        const std::size_t groups = padded(count) / kLanes;
        directions_.clear();
        for (std::size_t g = 0; g < groups; ++g) lanes_[g] = {};
        for (std::size_t i = 0; i < count; ++i) {
            directions_.push_back(
                unit(mesh_.vertices[edges_[i].other] - mesh_.vertices[vertex.vertex]));
            for (std::size_t axis = 0; axis < 3; ++axis)
                lanes_[i / kLanes][axis][i % kLanes] = static_cast<float>(directions_[i].c[axis]);
        }
        rays_.clear();
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t g = i / kLanes; g < groups; ++g)
                forEachSet(mayBound(i, g, count), [&](std::size_t lane) {
                    const std::size_t j = kLanes * g + lane;
                    if (j > i && j < count) addRays(i, j);
                });
        // One edge, or several on a line: a half-space or a plane.
        if (rays_.empty()) return onLine();
        setCone(rays_, vertex);  // else all directions count
        return true;
    }
    /// For each edge of a group, whether the normal of the plane of it and of edge i may be a ray
    /// of the polar cone. Beyond rounding it is not if it has products of both signs with others.
    Int8 mayBound(std::size_t i, std::size_t group, std::size_t count) const {
        constexpr float kRounding = 1e-6f;
        const Vec<3>& d = directions_[i];
        const auto dx = static_cast<float>(d[0]), dy = static_cast<float>(d[1]),
                   dz = static_cast<float>(d[2]);
        const auto& [ex, ey, ez] = lanes_[group];
        const Float8 x = dy * ez - dz * ey, y = dz * ex - dx * ez, z = dx * ey - dy * ex;
        Float8 low{}, high{};
        for (std::size_t k = 0; k < count; ++k) {
            const auto& [kx, ky, kz] = lanes_[k / kLanes];
            const std::size_t lane = k % kLanes;
            const Float8 product = x * kx[lane] + y * ky[lane] + z * kz[lane];
            low = smaller(low, product);
            high = larger(high, product);
        }
        return (high <= kRounding) | (low >= -kRounding);
    }
    void addRays(std::size_t i, std::size_t j) {
        const Vec<3> normal = cross(directions_[i], directions_[j]);
        // Of two parallel edges, one bounds the cone no less than the other.
        if (!(squaredLength(normal) > 1e-24)) return;
        for (const double sign : {1.0, -1.0}) {
            const Vec<3> ray = unit(normal) * sign;
            if (std::all_of(directions_.begin(), directions_.end(),
                            [&](const Vec<3>& d) { return dot(d, ray) <= 1e-9; }))
                rays_.push_back(ray);
        }
    }
    bool onLine() const {
        for (const auto& d : directions_)
            if (squaredLength(cross(d, directions_.front())) > 1e-24) return false;
        return true;
    }

    const BandMesh& mesh_;
    const FeatureVisits& visits_;
    std::vector<Corner> corners_;
    std::vector<Uses> edges_;
    std::unordered_map<std::uint32_t, std::size_t> numberOf_;  ///< of the edge to a vertex
    std::size_t numbered_ = 0;                                 ///< edges in it
    std::vector<Vec<3>> rays_, directions_;
    std::array<std::array<Float8, 3>, kMostEdges / kLanes> lanes_;  ///< `directions_`
};

}  // namespace

BandFeatures bandFeatures(const BandMesh& mesh, const FeatureVisits& visits,
                          const Callbacks& callbacks) {
    PerThread<BandFeatures> locals;
    PerThread<Neighborhood> neighborhoods([&] { return Neighborhood(mesh, visits); });
    Fans fans(mesh);
    callbacks.stopIfCancelled();
    parallelFor(IndexRange(0, mesh.vertices.size(), 4096), [&](const IndexRange& part) {
        BandFeatures& features = locals.local();
        Neighborhood& around = neighborhoods.local();
        for (std::size_t v = part.begin(); v < part.end(); ++v) {
            // Threads wrote them; sums shall not depend on which was first.
            std::sort(fans.first(v), fans.last(v));
            around.add(static_cast<std::uint32_t>(v), fans.first(v), fans.last(v), features);
        }
    });
    callbacks.stopIfCancelled();
    BandFeatures all;
    for (BandFeatures& f : locals) {
        all.edges.append(std::move(f.edges));
        all.vertices.append(std::move(f.vertices));
    }
    return all;
}

}  // namespace vdbpack
