#include "vdbpack/repair/solid_relations.h"

#include "vdbpack/mesh/triangle_crossing.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// About the number of triangles of a surface whose sides are tested against the other.
constexpr std::size_t kSamples = 2000;

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
        const auto [a, b, c] = cornersOf(mesh, mesh.triangles[i]);
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
      tree_(mesh_.triangles.size(),
            [&](std::size_t i) { return cornersOf(mesh_, mesh_.triangles[i]); }) {}

Box<3> Solid::boxOf(std::uint32_t triangle) const {
    Box<3> box;
    for (const std::uint32_t v : mesh_.triangles[triangle]) box.add(mesh_.vertices[v]);
    return box;
}

bool Solid::pierce(const Solid& small, const Solid& large, double tolerance) {
    for (std::uint32_t i = 0; i < small.mesh_.triangles.size(); ++i) {
        const Box<3> box = small.boxOf(i);
        if (!overlap(box, large.bounds_)) continue;
        const TriangleTree::Corners own = cornersOf(small.mesh_, small.mesh_.triangles[i]);
        bool any = false;
        large.tree_.visitNear(box.center(), 0.25 * squaredLength(box.size()), [&](std::uint32_t k) {
            if (!overlap(large.boxOf(k), box)) return false;
            const TriangleTree::Corners other = cornersOf(large.mesh_, large.mesh_.triangles[k]);
            const auto inSmall = [&](const Vec<3>& x) { return small.sides_.inside(x); };
            const auto inLarge = [&](const Vec<3>& x) { return large.sides_.inside(x); };
            any = anyEdgePasses(own, other, inLarge, tolerance) ||
                  anyEdgePasses(other, own, inSmall, tolerance);
            return any;
        });
        if (any) return true;
    }
    return false;
}

SolidRelation relationOf(const Solid& a, const Solid& b) {
    if (!overlap(a.bounds_, b.bounds_)) return SolidRelation::apart;
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
