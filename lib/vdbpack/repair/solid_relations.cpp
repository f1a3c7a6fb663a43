#include "vdbpack/repair/solid_relations.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// About the number of triangles of a surface whose sides are tested against the other.
constexpr std::size_t kSamples = 2000;
/// Surfaces closer than this share of their size touch: rounding to 32 bits.
constexpr double kTouching = 1e-6;

bool meet(const Box<3>& a, const Box<3>& b) {
    return !intersection(a, b).empty();
}

struct TriangleCorners {
    Vec<3> a, b, c;
};

TriangleCorners cornersOf(const TriangleMesh& mesh, std::uint32_t triangle) {
    const auto& t = mesh.triangles[triangle];
    return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

/// Whether the segment passes through the triangle, with both ends off its plane; `at` is a point
/// on it just behind the triangle.
bool passes(const Vec<3>& p, const Vec<3>& q, const TriangleCorners& t, double tolerance,
            Vec<3>& at) {
    const Vec<3> normal = cross(t.b - t.a, t.c - t.a);
    const double size = length(normal);
    if (!(size > 0)) return false;
    const double before = dot(normal, p - t.a), after = dot(normal, q - t.a);
    if ((before > 0) == (after > 0)) return false;
    if (std::min(std::fabs(before), std::fabs(after)) <= tolerance * size) return false;
    at = p + (q - p) * (before / (before - after));
    const auto isLeft = [&](const Vec<3>& from, const Vec<3>& to) {
        return dot(normal, cross(to - from, at - from)) >= 0;
    };
    if (!isLeft(t.a, t.b) || !isLeft(t.b, t.c) || !isLeft(t.c, t.a)) return false;
    const double depth = -std::min(before, after) / size;  // of the end behind the triangle
    at += ((before < 0 ? p : q) - at) * std::min(1.0, 4 * tolerance / depth);
    return true;
}

/// Whether an edge of a triangle passes through another one, with a part of the first solid behind
/// that. @param sides  of the solid of the second triangle.
bool anyEdgePasses(const TriangleCorners& own, const TriangleCorners& other, const MeshSides& sides,
                   double tolerance) {
    const Vec<3> ends[4] = {own.a, own.b, own.c, own.a};
    for (int k = 0; k < 3; ++k) {
        Vec<3> x;
        if (!passes(ends[k], ends[k + 1], other, tolerance, x)) continue;
        // Into the solid of the edge: an edge that runs along the other's surface only touches it.
        const Vec<3> middle = (own.a + own.b + own.c) * (1.0 / 3) - x;
        const Vec<3> back = cross(own.c - own.a, own.b - own.a);
        if (!(squaredLength(back) > 0) || !(squaredLength(middle) > 0)) continue;
        if (sides.inside(x + (normalized(middle) + normalized(back)) * tolerance)) return true;
    }
    return false;
}

/// Triangles of one surface by where their two sides are in another.
struct Sides {
    std::size_t inside = 0, outside = 0;
    std::size_t coinciding = 0;  ///< only the back is inside

    bool allInside() const { return inside > 0 && outside + coinciding == 0; }
    bool meets() const { return coinciding > 0 || inside > 0; }
};

Sides sidesIn(const TriangleMesh& mesh, const MeshSides& other, const Box<3>& bounds,
              double tolerance) {
    Sides sides;
    const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / kSamples);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); i += static_cast<std::uint32_t>(step)) {
        const auto [a, b, c] = cornersOf(mesh, i);
        const Vec<3> normal = cross(b - a, c - a);
        const double twice = length(normal);
        if (!(twice > 0)) continue;
        const Vec<3> center = (a + b + c) * (1.0 / 3);
        const Vec<3> aside = normal * (std::max(1e-3 * std::sqrt(twice), tolerance) / twice);
        const bool back = bounds.contains(center - aside) && other.inside(center - aside);
        const bool front = bounds.contains(center + aside) && other.inside(center + aside);
        ++(!back ? sides.outside : front ? sides.inside : sides.coinciding);
    }
    return sides;
}

}  // namespace

Solid::Solid(TriangleMesh mesh)
    : mesh_(std::move(mesh)),
      bounds_(mesh_.bounds()),
      sides_(mesh_, true),
      tree_(mesh_.triangles.size(), [&](std::size_t i) {
          const TriangleCorners t = cornersOf(mesh_, static_cast<std::uint32_t>(i));
          return TriangleTree::Corners{t.a, t.b, t.c};
      }) {}

Box<3> Solid::boxOf(std::uint32_t triangle) const {
    Box<3> box;
    for (const std::uint32_t v : mesh_.triangles[triangle]) box.add(mesh_.vertices[v]);
    return box;
}

bool Solid::pierce(const Solid& small, const Solid& large, double tolerance) {
    for (std::uint32_t i = 0; i < small.mesh_.triangles.size(); ++i) {
        const Box<3> box = small.boxOf(i);
        if (!meet(box, large.bounds_)) continue;
        const TriangleCorners own = cornersOf(small.mesh_, i);
        bool any = false;
        large.tree_.visitNear(box.center(), 0.25 * squaredLength(box.size()), [&](std::uint32_t k) {
            if (!meet(large.boxOf(k), box)) return false;
            const TriangleCorners other = cornersOf(large.mesh_, k);
            any = anyEdgePasses(own, other, large.sides_, tolerance) ||
                  anyEdgePasses(other, own, small.sides_, tolerance);
            return any;
        });
        if (any) return true;
    }
    return false;
}

SolidRelation relationOf(const Solid& a, const Solid& b) {
    if (!meet(a.bounds_, b.bounds_)) return SolidRelation::apart;
    const double tolerance =
        kTouching * std::min(length(a.bounds_.size()), length(b.bounds_.size()));
    const bool aIsSmaller = a.mesh_.triangles.size() < b.mesh_.triangles.size();
    if (Solid::pierce(aIsSmaller ? a : b, aIsSmaller ? b : a, tolerance))
        return SolidRelation::intersect;
    const Sides ofA = sidesIn(a.mesh_, b.sides_, b.bounds_, tolerance);
    if (ofA.allInside()) return SolidRelation::inside;
    const Sides ofB = sidesIn(b.mesh_, a.sides_, a.bounds_, tolerance);
    if (ofB.allInside()) return SolidRelation::around;
    return ofA.meets() || ofB.meets() ? SolidRelation::intersect : SolidRelation::apart;
}

}  // namespace vdbpack
