#include "vdbpack/densify/wall_planes.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// A wall point that lies above the planes of nearer points by less than this (in radii) adds no
/// plane.
constexpr double kRise = 1e-6;

}  // namespace

template <int Dim>
WallPlanes<Dim>::WallPlanes(const Domain<Dim>& domain, double quantum)
    : domain_(domain),
      quantum_(quantum),
      fieldError_(domain.facts().voxelSize / quantum),
      fieldDepth_(domain.fieldDepth() / quantum) {}

template <int Dim>
WallPlanes<Dim>::~WallPlanes() = default;

template <int Dim>
typename WallPlanes<Dim>::Asker& WallPlanes<Dim>::asker() {
    Asker& mine = askers_.local();
    if (!mine.sampler) mine.sampler = domain_.sampler();
    return mine;
}

template <int Dim>
Vec<Dim> WallPlanes<Dim>::position(const Home& home) const {
    Vec<Dim> x;
    for (int d = 0; d < Dim; ++d)
        x[d] = static_cast<double>(home[static_cast<std::size_t>(d)]) * quantum_;
    return x;
}

template <int Dim>
bool WallPlanes<Dim>::isDue(const Body& body, const Vicinity& vicinity, float margin) const {
    if (vicinity.wall == kNone) return true;
    const Wall& wall = walls_[vicinity.wall];
    if (wall.count == 0) return true;
    // The way from the position of the last query counts.
    const float dx = difference(body.x, wall.x), dy = difference(body.y, wall.y),
                dz = difference(body.z, wall.z);
    const float way = std::sqrt(dx * dx + dy * dy + dz * dz);
    return way > slide_ * body.radius || wall.seen - way < body.radius + margin;
}

template <int Dim>
void WallPlanes<Dim>::ask(const Home& home, const Body& body, float margin, Vicinity& vicinity) {
    Asker& asker = this->asker();
    const Vec<Dim> x = position(home);
    const double radius = static_cast<double>(body.radius);
    const double need = radius + static_cast<double>(margin);
    const double slide = static_cast<double>(slide_) * radius;
    const double seen = need + 2 * slide;
    const double inside = -asker.sampler->signedDistance(x) / quantum_;
    const double least = std::min(inside, fieldDepth_) - fieldError_;
    auto& points = asker.points;
    points.clear();
    if (least <= seen) asker.sampler->wallsWithin(x, seen * quantum_, points);
    if (points.empty()) {
        vicinity.roam = static_cast<float>(std::max(least - need, 2 * slide));
        // No wall is near any more, unless the center is far outside the domain.
        if (inside > -fieldError_ && vicinity.wall != kNone) walls_[vicinity.wall].count = 0;
        return;
    }
    std::sort(points.begin(), points.end(), [](const WallPoint<Dim>& a, const WallPoint<Dim>& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.point.c < b.point.c;
    });
    if (vicinity.wall == kNone)
        vicinity.wall = static_cast<std::uint32_t>(walls_.push_back(Wall{}) - walls_.begin());
    Wall& wall = walls_[vicinity.wall];
    wall.count = 0;
    wall.seen = static_cast<float>(seen);
    wall.x = body.x, wall.y = body.y, wall.z = body.z;
    const double distance = points.front().distance / quantum_;
    vicinity.roam = static_cast<float>(distance - need);
    // Where the field's distance is right, its side is right too.
    const bool known = distance > fieldError_ && std::abs(inside) > 0.5 * distance;
    const bool within = known ? inside > 0 : asker.sampler->contains(x);
    addPlanes(x, radius, within, points, wall);
}

template <int Dim>
void WallPlanes<Dim>::addPlanes(const Vec<Dim>& x, double radius, bool within,
                                std::vector<WallPoint<Dim>>& points, Wall& wall) const {
    std::array<Vec<Dim>, kMostPlanes> normals;
    for (const WallPoint<Dim>& found : points) {
        // The plane of a nearer point keeps the sphere away from what lies behind it.
        const auto isBehind = [&](std::uint32_t k) {
            return dot(normals[k], found.point - points[k].point) <= kRise * radius * quantum_;
        };
        std::uint32_t k = 0;
        while (k < wall.count && !isBehind(k)) ++k;
        if (k < wall.count) continue;
        const Vec<Dim> normal = normalized(within ? x - found.point : found.point - x);
        if (squaredLength(normal) == 0) continue;
        normals[wall.count] = normal;
        WallPlane& plane = wall.planes[wall.count];
        plane.nx = static_cast<float>(normal[0]);
        plane.ny = static_cast<float>(normal[1]);
        std::array<std::uint32_t*, 3> to{&plane.x, &plane.y, &plane.z};
        for (int d = 0; d < Dim; ++d)
            *to[static_cast<std::size_t>(d)] =
                lowBits(static_cast<std::int64_t>(std::nearbyint(found.point[d] / quantum_)));
        if constexpr (Dim > 2) plane.nz = static_cast<float>(normal[2]);
        // The points of planes move to the front of `points`, in the same order.
        points[wall.count] = found;
        if (++wall.count == kMostPlanes || !within) break;
    }
}

template <int Dim>
bool WallPlanes<Dim>::allows(const Home& home, const Body& body, double grow) {
    DomainSampler<Dim>& sampler = this->sampler();
    const Vec<Dim> x = position(home);
    const double radius = static_cast<double>(body.radius) * grow;
    const double inside = -sampler.signedDistance(x) / quantum_;
    if (std::min(inside, fieldDepth_) - fieldError_ > radius) return true;
    return !sampler.isWallCloser(x, radius * quantum_) &&
           (inside > fieldError_ || sampler.contains(x));
}

template class WallPlanes<2>;
template class WallPlanes<3>;

}  // namespace vdbpack
