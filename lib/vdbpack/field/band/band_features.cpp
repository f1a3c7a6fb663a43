#include "vdbpack/field/band/band_features.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/parallel.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace vdbpack {

namespace {

/// Sine of the angle at an edge below which it counts as flat.
constexpr double kFlat = 1e-7;
/// Cones of vertices with more edges are not computed: all directions count.
constexpr std::size_t kMostEdges = 24;

/// The triangles at each vertex, by rising number.
struct Corners {
    std::vector<std::uint32_t> start, triangle;

    explicit Corners(const BandMesh& mesh) {
        const auto& triangles = *mesh.triangles;
        std::vector<std::atomic<std::uint32_t>> next(mesh.vertices.size());
        forAll(triangles.size(), [&](std::size_t i) {
            for (const auto v : triangles[i]) next[v].fetch_add(1, std::memory_order_relaxed);
        });
        triangle.resize(
            firstPositions(next, start, "corners of triangles", "use a mesh of fewer triangles"));
        forAll(triangles.size(), [&](std::size_t i) {
            for (const auto v : triangles[i])
                triangle[next[v].fetch_add(1, std::memory_order_relaxed)] =
                    static_cast<std::uint32_t>(i);
        });
    }
};

/// A triangle at an edge from the vertex that is worked on.
struct Use {
    std::uint32_t other;  ///< the vertex at the other end
    std::uint32_t triangle;
    std::uint32_t third;  ///< the triangle's third vertex
};

enum class Bend { flat, above, below, unknown };

/// How the triangles at an edge meet.
struct Wedge {
    Bend bend = Bend::unknown;  ///< where it opens: to the side of the normals, to the other, ...
    float reach = 0;
    bool bounded = false;  ///< by one or two triangles
};

Vec<3> unit(const Vec<3>& v) {
    const double l = length(v);
    return l > 0 ? v * (1 / l) : Vec<3>{};
}

class Neighborhood {
public:
    explicit Neighborhood(const BandMesh& mesh) : mesh_(mesh) {}

    void collect(std::uint32_t v, const std::uint32_t* first, const std::uint32_t* last) {
        uses_.clear();
        for (; first != last; ++first) {
            const auto& t = (*mesh_.triangles)[*first];
            for (std::size_t k = 0; k < 3; ++k) {
                if (t[k] != v) continue;
                const std::uint32_t p = t[(k + 1) % 3], q = t[(k + 2) % 3];
                if (p == v || q == v) continue;  // collapsed: no more than its edges
                uses_.push_back({p, *first, q});
                uses_.push_back({q, *first, p});
            }
        }
        std::sort(uses_.begin(), uses_.end(), [](const Use& a, const Use& b) {
            return a.other != b.other ? a.other < b.other : a.triangle < b.triangle;
        });
    }

    /// The wedge at the edge from `v` of the uses [first, last).
    Wedge wedgeOf(std::uint32_t v, const Use* first, const Use* last) const {
        Wedge wedge;
        const Vec<3>& a = mesh_.vertices[v];
        const Vec<3> along = unit(mesh_.vertices[first->other] - a);
        for (const Use* u = first; u != last; ++u)
            wedge.reach = std::max(wedge.reach, mesh_.widths(u->triangle).larger());
        const auto count = last - first;
        if (count > 2) return wedge;
        Vec<3> into[2], normal[2];
        for (int k = 0; k < count; ++k) {
            const Use& use = first[k];
            normal[k] = normalOf(use.triangle);
            if (!(squaredLength(normal[k]) > 0)) return wedge;
            const Vec<3> to = mesh_.vertices[use.third] - a;
            into[k] = unit(to - along * dot(to, along));
        }
        wedge.bounded = true;
        if (count == 1) return wedge;
        const Vec<3> opens = (into[0] + into[1]) * -1.0;
        if (!(length(opens) > kFlat)) {
            wedge.bend = Bend::flat;
            return wedge;
        }
        const double side0 = dot(normal[0], opens), side1 = dot(normal[1], opens);
        // Folded back, or triangles that face different ways.
        if (std::min(std::abs(side0), std::abs(side1)) < 1e-3 * length(opens) ||
            (side0 > 0) != (side1 > 0))
            return wedge;
        wedge.bend = side0 > 0 ? Bend::above : Bend::below;
        wedge.reach = 0;
        for (int k = 0; k < 2; ++k) {
            const BandWidths w = mesh_.widths(first[k].triangle);
            wedge.reach = std::max(wedge.reach, side0 > 0 ? w.above : w.below);
        }
        return wedge;
    }

    /// Adds the edges from `v` to higher vertices, and `v`.
    void add(std::uint32_t v, BandFeatures& to) {
        bool above = false, below = false, general = false;
        float reach = 0;
        others_.clear();
        for (const Use* first = uses_.data(); first != uses_.data() + uses_.size();) {
            const Use* last = first;
            while (last != uses_.data() + uses_.size() && last->other == first->other) ++last;
            const Wedge wedge = wedgeOf(v, first, last);
            others_.push_back(first->other);
            above |= wedge.bend == Bend::above;
            below |= wedge.bend == Bend::below;
            general |= wedge.bend == Bend::unknown;
            if (wedge.bend != Bend::flat) {
                reach = std::max(reach, wedge.reach);
                if (v < first->other) {
                    const bool two = wedge.bounded && last - first == 2;
                    to.edges.push_back({v, first->other,
                                        wedge.bounded ? first->third : BandEdge::kNone,
                                        two ? first[1].third : BandEdge::kNone, wedge.reach});
                }
            }
            first = last;
        }
        if (!above && !below && !general) return;
        BandVertex vertex{v, reach, {}, -1};
        if (!general && above != below)
            coneOfNormals(above ? 1 : -1, vertex);
        else if (!polarCone(v, vertex))
            return;
        to.vertices.push_back(vertex);
    }

private:
    Vec<3> normalOf(std::uint32_t triangle) const {
        return bandNormal(mesh_.corner(triangle, 0), mesh_.corner(triangle, 1),
                          mesh_.corner(triangle, 2));
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

    /// Where all edges bend the same way the normals are the extreme rays.
    void coneOfNormals(int side, BandVertex& vertex) {
        rays_.clear();
        for (const Use& use : uses_)
            if (use.other < use.third) rays_.push_back(normalOf(use.triangle) * side);
        setCone(rays_, vertex);
    }

    /// The cone of the points whose product with no edge is positive. @return whether there are
    /// any.
    bool polarCone(std::uint32_t v, BandVertex& vertex) {
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
    std::vector<Use> uses_;
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

BandFeatures bandFeatures(const BandMesh& mesh, const Callbacks& callbacks) {
    Corners corners(mesh);
    callbacks.stopIfCancelled();
    struct Local {
        BandFeatures features;
        std::vector<std::uint32_t> triangles;
    };
    tbb::enumerable_thread_specific<Local> locals;
    tbb::enumerable_thread_specific<Neighborhood> neighborhoods([&] { return Neighborhood(mesh); });
    const std::size_t n = mesh.vertices.size();
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, n, 4096),
        [&](const tbb::blocked_range<std::size_t>& part) {
            BandFeatures& features = locals.local().features;
            Neighborhood& around = neighborhoods.local();
            for (std::size_t v = part.begin(); v < part.end(); ++v) {
                std::uint32_t* const first = corners.triangle.data() + corners.start[v];
                std::uint32_t* const last = corners.triangle.data() + corners.start[v + 1];
                if (first == last) continue;
                around.collect(static_cast<std::uint32_t>(v), first, last);
                around.add(static_cast<std::uint32_t>(v), features);
            }
        });
    callbacks.stopIfCancelled();
    BandFeatures all;
    for (Local& local : locals) {
        const BandFeatures& f = local.features;
        all.edges.insert(all.edges.end(), f.edges.begin(), f.edges.end());
        all.vertices.insert(all.vertices.end(), f.vertices.begin(), f.vertices.end());
        local = {};
    }
    return all;
}

}  // namespace vdbpack
