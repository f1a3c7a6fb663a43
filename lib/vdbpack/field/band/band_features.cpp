#include "vdbpack/field/band/band_features.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/parallel.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Sine of the angle at an edge below which it counts as flat.
constexpr double kFlat = 1e-7;
/// Normals that differ by less are of one plane.
constexpr double kSame = 1e-9;
/// Cones of vertices with more edges are not computed: all directions count.
constexpr std::size_t kMostEdges = 24;
/// Vertices that are worked on at a time, which bounds the memory for their triangles.
constexpr std::size_t kVerticesAtATime = std::size_t{1} << 20;

/// The triangles at each of some vertices, in any order.
class Corners {
public:
    /// @param begin, end  the vertices.
    Corners(const BandMesh& mesh, std::size_t begin, std::size_t end) : begin_(begin) {
        const auto& triangles = *mesh.triangles;
        std::vector<std::atomic<std::uint32_t>> next(end - begin);
        const auto forEachCorner = [&](const auto& visit) {
            forAll(triangles.size(), [&](std::size_t i) {
                for (const std::size_t v : triangles[i])
                    if (v - begin < next.size()) visit(next[v - begin], i);
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
    std::uint32_t* first(std::size_t v) { return triangle_.data() + start_[v - begin_]; }
    std::uint32_t* last(std::size_t v) { return triangle_.data() + start_[v - begin_ + 1]; }

private:
    std::size_t begin_;
    std::vector<std::uint32_t> start_, triangle_;
};

/// An edge from the vertex that is worked on, and its first two triangles.
struct Uses {
    std::uint32_t other;  ///< the vertex at the other end
    std::uint32_t count;  ///< triangles at the edge
    std::array<std::uint32_t, 2> triangle;
    std::array<bool, 2> forward;  ///< the triangle runs from this vertex to the other
    float widest;                 ///< of the bands at all triangles
};

/// The side to which the wedge between the triangles at an edge opens: that of their normals, the
/// other, ... Bits, so that those of a vertex's edges can be collected.
enum Bend : std::uint8_t { flat = 0, above = 1, below = 2, unknown = 4 };
using Bends = std::vector<std::atomic<std::uint8_t>>;

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
    /// @param bends  of the edges at each vertex: collected by `addEdges`, read by `addVertex`.
    Neighborhood(const BandMesh& mesh, const FeatureVisits& visits, Bends& bends)
        : mesh_(mesh), visits_(visits), bends_(bends) {}

    /// Adds the edges from `v` to higher vertices. @param first, last  the triangles at `v`.
    void addEdges(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last,
                  BlockList<BandEdge>& edges) {
        edges_.clear();
        forEachCorner(v, first, last, [&](std::uint32_t triangle, std::uint32_t k) {
            const auto& t = (*mesh_.triangles)[triangle];
            const std::uint32_t next = t[(k + 1) % 3], before = t[(k + 2) % 3];
            if (next > v) addUse(next, triangle, true);
            if (before > v) addUse(before, triangle, false);
        });
        for (const Uses& uses : edges_) {
            BandEdge edge{v, uses.other, uses.widest, {}, {}};
            const Bend bend = wedgeOf(uses, edge);
            if (bend == Bend::flat) continue;
            if (bend != Bend::unknown)
                edge.reach = std::max(reachOf(bend, mesh_.widths(uses.triangle[0])),
                                      reachOf(bend, mesh_.widths(uses.triangle[1])));
            for (const std::uint32_t of : {edge.a, edge.b})
                if ((bends_[of].load(std::memory_order_relaxed) & bend) == 0)
                    bends_[of].fetch_or(bend, std::memory_order_relaxed);
            if (!visits_.edge(edge)) edges.add(edge);
        }
    }

    /// Adds `v`, if it matters.
    void addVertex(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last,
                   BlockList<BandVertex>& vertices) {
        const unsigned bends = bends_[v].load(std::memory_order_relaxed);
        if (bends == Bend::flat) return;
        BandVertex vertex{v, 0, {}, -1};
        forEachCorner(v, first, last, [&](std::uint32_t triangle, std::uint32_t) {
            vertex.reach = std::max(vertex.reach, reachOf(bends, mesh_.widths(triangle)));
        });
        const bool matters =
            bends == Bend::above || bends == Bend::below
                ? coneOfNormals(v, first, last, bends == Bend::above ? 1 : -1, vertex)
                : polarCone(v, first, last, vertex);
        if (!matters) return;
        if (!visits_.vertex(vertex)) vertices.add(vertex);
    }

private:
    /// Calls `visit(triangle, k)` where `v` is corner k; not for triangles with two equal corners,
    /// which are no more than an edge of others.
    template <class Visit>
    void forEachCorner(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last,
                       const Visit& visit) const {
        for (; first != last; ++first) {
            const auto& t = (*mesh_.triangles)[*first];
            if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
            visit(*first, t[0] == v ? 0u : t[1] == v ? 1u : 2u);
        }
    }

    void addUse(std::uint32_t other, std::uint32_t triangle, bool forward) {
        const float widest = mesh_.widths(triangle).larger();
        for (Uses& uses : edges_) {
            if (uses.other != other) continue;
            if (uses.count == 1) {
                uses.triangle[1] = triangle;
                uses.forward[1] = forward;
            }
            ++uses.count;
            uses.widest = std::max(uses.widest, widest);
            return;
        }
        edges_.push_back({other, 1, {triangle, 0}, {forward, false}, widest});
    }

    /// How the triangles at an edge meet; sets the edge's planes.
    Bend wedgeOf(const Uses& uses, BandEdge& edge) const {
        if (uses.count > 2) return Bend::unknown;
        Vec<3> normal[2];
        for (std::size_t k = 0; k < uses.count; ++k) {
            normal[k] = mesh_.normals[uses.triangle[k]];
            if (!(squaredLength(normal[k]) > 0)) return Bend::unknown;
        }
        // The wedge is as wide as the normals differ.
        const double opening = uses.forward[0] != uses.forward[1] ? length(normal[0] - normal[1])
                                                                  : length(normal[0] + normal[1]);
        if (uses.count == 2 && !(opening > kFlat)) return Bend::flat;
        const Vec<3> e = mesh_.vertices[edge.b] - mesh_.vertices[edge.a];
        const double inverse = 1 / length(e);
        if (!std::isfinite(inverse)) return Bend::unknown;
        const auto away = [&](std::size_t k) {
            return cross(normal[k], e) * (uses.forward[k] ? -inverse : inverse);
        };
        edge.away0 = away(0);
        if (uses.count == 1) return Bend::unknown;
        edge.away1 = away(1);
        const Vec<3> opens = edge.away0 + edge.away1;
        const double side0 = dot(normal[0], opens), side1 = dot(normal[1], opens);
        // Folded back, or triangles that face different ways.
        if (std::min(std::abs(side0), std::abs(side1)) < 1e-3 * opening ||
            (side0 > 0) != (side1 > 0))
            return Bend::unknown;
        return side0 > 0 ? Bend::above : Bend::below;
    }

    void setCone(const std::vector<Vec<3>>& rays, BandVertex& vertex) const {
        Vec<3> sum{};
        for (const auto& r : rays) sum = sum + r;
        const Vec<3> axis = unit(sum);
        double cosine = 1;
        for (const auto& r : rays) cosine = std::min(cosine, dot(r, axis));
        // Beyond a right angle rays no longer bound a convex cone.
        if (!(cosine > 0.01)) return;
        for (int i = 0; i < 3; ++i)
            vertex.axis[static_cast<std::size_t>(i)] = static_cast<float>(axis[i]);
        vertex.cosine = static_cast<float>(cosine - 1e-6);
    }

    /// Where all edges bend the same way the normals are the extreme rays of the cone of points
    /// that are nearest to the vertex. @return false for a vertex within a straight edge.
    bool coneOfNormals(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last,
                       int side, BandVertex& vertex) {
        rays_.clear();
        forEachCorner(v, first, last, [&](std::uint32_t triangle, std::uint32_t) {
            const Vec<3> ray = mesh_.normals[triangle] * side;
            if (std::none_of(rays_.begin(), rays_.end(), [&](const Vec<3>& other) {
                    return squaredLength(ray - other) < kSame * kSame;
                }))
                rays_.push_back(ray);
        });
        if (rays_.size() <= 2) return false;
        setCone(rays_, vertex);
        return true;
    }

    /// The cone of the points whose product with no edge is positive. @return whether there are
    /// any.
    bool polarCone(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last,
                   BandVertex& vertex) {
        others_.clear();
        forEachCorner(v, first, last, [&](std::uint32_t triangle, std::uint32_t k) {
            const auto& t = (*mesh_.triangles)[triangle];
            others_.insert(others_.end(), {t[(k + 1) % 3], t[(k + 2) % 3]});
        });
        std::sort(others_.begin(), others_.end());
        others_.erase(std::unique(others_.begin(), others_.end()), others_.end());
        if (others_.size() > kMostEdges) return true;
        directions_.clear();
        for (const auto other : others_)
            directions_.push_back(unit(mesh_.vertices[other] - mesh_.vertices[v]));
        rays_.clear();
        for (std::size_t i = 0; i < directions_.size(); ++i)
            for (std::size_t j = i + 1; j < directions_.size(); ++j) {
                const Vec<3> normal = cross(directions_[i], directions_[j]);
                // Of two parallel edges, one bounds the cone no less than the other.
                if (!(squaredLength(normal) > 1e-24)) continue;
                for (const double sign : {1.0, -1.0}) {
                    const Vec<3> ray = unit(normal) * sign;
                    if (std::all_of(directions_.begin(), directions_.end(),
                                    [&](const Vec<3>& d) { return dot(d, ray) <= 1e-9; }))
                        rays_.push_back(ray);
                }
            }
        // One edge, or several on a line: a half-space or a plane.
        if (rays_.empty()) return onLine();
        setCone(rays_, vertex);
        return true;
    }
    bool onLine() const {
        for (const auto& d : directions_)
            if (squaredLength(cross(d, directions_.front())) > 1e-24) return false;
        return true;
    }

    const BandMesh& mesh_;
    const FeatureVisits& visits_;
    Bends& bends_;
    std::vector<Uses> edges_;
    std::vector<std::uint32_t> others_;
    std::vector<Vec<3>> rays_, directions_;
};

}  // namespace

Vec<3> bandNormal(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
    // The height over the longest side is what the normal depends on.
    const Vec<3> ab = b - a, ac = c - a, bc = c - b;
    const Vec<3> n = cross(ab, ac);
    const double longest = std::max({squaredLength(ab), squaredLength(ac), squaredLength(bc)});
    const double square = squaredLength(n);
    if (!(square > 1e-14 * longest)) return {};
    return n * (1 / std::sqrt(square));
}

BandFeatures bandFeatures(const BandMesh& mesh, const FeatureVisits& visits,
                          const Callbacks& callbacks) {
    Bends bends(mesh.vertices.size());
    tbb::enumerable_thread_specific<BandFeatures> locals;
    tbb::enumerable_thread_specific<Neighborhood> neighborhoods(
        [&] { return Neighborhood(mesh, visits, bends); });
    const auto forEachVertex = [&](std::size_t begin, std::size_t end, const auto& work) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, 4096),
                          [&](const tbb::blocked_range<std::size_t>& part) {
                              BandFeatures& features = locals.local();
                              Neighborhood& around = neighborhoods.local();
                              for (std::size_t v = part.begin(); v < part.end(); ++v)
                                  work(static_cast<std::uint32_t>(v), around, features);
                          });
        callbacks.stopIfCancelled();
    };
    for (std::size_t begin = 0; begin < mesh.vertices.size(); begin += kVerticesAtATime) {
        const std::size_t end = std::min(begin + kVerticesAtATime, mesh.vertices.size());
        Corners corners(mesh, begin, end);
        callbacks.stopIfCancelled();
        forEachVertex(begin, end,
                      [&](std::uint32_t v, Neighborhood& around, BandFeatures& features) {
                          // Threads wrote them; sums shall not depend on which was first.
                          std::sort(corners.first(v), corners.last(v));
                          around.addEdges(v, corners.first(v), corners.last(v), features.edges);
                      });
        // The edges from lower vertices are known, too.
        forEachVertex(begin, end,
                      [&](std::uint32_t v, Neighborhood& around, BandFeatures& features) {
                          around.addVertex(v, corners.first(v), corners.last(v), features.vertices);
                      });
    }
    BandFeatures all;
    for (BandFeatures& f : locals) {
        all.edges.append(std::move(f.edges));
        all.vertices.append(std::move(f.vertices));
    }
    return all;
}

}  // namespace vdbpack
