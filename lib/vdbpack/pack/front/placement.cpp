#include "vdbpack/pack/front/placement.h"

#include "vdbpack/core/lanes.h"
#include "vdbpack/pack/front/touching.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Tangent planes that one pivot may collect; corners need three, rough walls a few more.
constexpr int kMaxPlanes = 12;

/// Steps of a sphere that is moved ahead of the front until it is clear.
constexpr int kSetDownSteps = 20;

}  // namespace

/// Decides in double whether a sphere at `center` overlaps one of `around_`.
template <int Dim>
bool Placement<Dim>::overlaps(const Vec<Dim>& center, double radius) const {
    const auto r = static_cast<float>(radius * (1 + 1e-4));  // more than floats are off by
    const auto& near = around_.spheres;
    for (std::size_t i = 0; i < near.count; i += kLanes) {
        Float8 square{};
        for (std::size_t d = 0; d < Dim; ++d) {
            const Float8 to = load(&near.to[d][i]);
            square += to * to;
        }
        const Float8 least = load(&near.radius[i]) * (1 + 1e-6f) + r;
        const Int8 close = square < least * least;
        if (noneOf(close)) continue;
        bool disjoint = true;
        forEachSet(close, [&](std::size_t l) {
            const Sphere<Dim>& s = sphere(near.index[i + l]);
            const double exact = s.radius + radius;
            disjoint = disjoint && squaredLength(center - s.center) >= exact * exact;
        });
        if (!disjoint) return true;
    }
    return false;
}

/// Adds a sphere; `around_` and `wall_` are those of its center.
template <int Dim>
void Placement<Dim>::add(const Sphere<Dim>& sphere) {
    const std::uint32_t index = front_.add(sphere);
    if (hasWall_) front_.walls.add(index, wall_);
    front_.sites.keepOff(index, around_);
    front_.sites.find(index, Surroundings<Dim>::kAll, around_, index < front_.standing);
}

template <int Dim>
void Placement<Dim>::explore(std::uint32_t index) {
    const Sphere<Dim> s = sphere(index);
    const double reach = front_.reachOf(index);
    collect(s.center, reach, index);
    TangentPlane<Dim> plane;
    double distance;
    if (front_.block.findWall(s.center, s.center, s.radius, reach, plane, distance))
        front_.walls.add(index, plane);
    front_.sites.find(index, Surroundings<Dim>::kAll, around_, index < front_.standing);
}

template <int Dim>
typename Placement<Dim>::Outcome Placement<Dim>::placeAtSite(std::uint32_t site, double radius,
                                                             Vec<Dim> center, const LocalSize& size,
                                                             const FrontLengths& lengths) {
    const BlockState<Dim>& block = front_.block;
    const Vec<Dim> guess = center;
    const std::uint32_t pivot = front_.sites.pivot(site);
    const auto leave = [&] {
        front_.sites.leave(site, center);
        return Outcome::foreign;
    };
    if (!block.own.grown(0.5 * radius).contains(center)) return leave();
    if (!followWalls(site, radius, center)) return Outcome::blocked;
    center = block.snapped(center);
    if (!block.owns(center)) return leave();
    // One far larger than most has many neighbors, and most positions are too narrow for it.
    if (radius > lengths.commonRadius && !block.isFree(center, radius)) return Outcome::blocked;
    const double reach = radius + lengths.reach;
    collect(center, reach, FrontSites<Dim>::kNone);
    if (overlaps(center, radius)) return Outcome::blocked;
    if (const auto later = front_.sites.precededIn(site, center, radius, around_)) {
        front_.sites.leaveTo(site, later);
        return Outcome::foreign;
    }
    double distance = 0;
    hasWall_ = block.findWall(sphere(pivot).center, center, radius, reach, wall_, distance);
    if (!hasWall_ || distance >= radius) {
        // What touches the pivot is inside; but along a wall that bends away, the center may have
        // been led off the pivot, to the other side of the wall.
        const Vec<Dim> global = center + block.origin;
        if (block.sampler->signedDistance(global) > 0 && !block.sampler->contains(global))
            return Outcome::blocked;
        // Along a curved wall the center has moved.
        if (block.local && !LocalLengths<Dim>::areAlike(size, block.sizeAt(center)))
            return Outcome::blocked;
        front_.sites.remove(site);
        add({center, radius});
        return Outcome::placed;
    }
    // A wall that the pivot did not know. Learn its plane, unless the plane leaves this site
    // as it is: then it would come up again and again.
    if (front_.walls.count(pivot) < kMaxPlanes &&
        dot(guess - wall_.point, wall_.normal) < radius * (1 - 1e-4)) {
        learn(pivot, wall_);
        return Outcome::wallLearned;
    }
    return Outcome::blocked;
}

template <int Dim>
bool Placement<Dim>::tighten(std::uint32_t site, double radius, const Vec<Dim>& center) {
    const float before = front_.sites.limit(site);
    front_.block.cells.near(center, radius, [&](std::uint32_t i) {
        const double least = sphere(i).radius + radius;
        if (i != front_.sites.pivot(site) &&
            squaredLength(sphere(i).center - center) < least * least)
            front_.sites.keepOff(site, i);
        return !front_.sites.isRemoved(site);
    });
    return front_.sites.isRemoved(site) || front_.sites.limit(site) < before;
}

/// Gives a pivot a wall that it did not know of.
template <int Dim>
void Placement<Dim>::learn(std::uint32_t pivot, const TangentPlane<Dim>& plane) {
    const std::uint32_t wall = front_.walls.add(pivot, plane);
    front_.sites.keepOffWall(pivot, wall);
    collect(sphere(pivot).center, front_.reachOf(pivot), pivot);
    front_.sites.find(pivot, FrontSites<Dim>::kWallBody + wall, around_, pivot < front_.standing);
}

/// Moves a center that rests on walls to where it touches the walls themselves: the planes that
/// the pivot knows are a first guess where walls are curved.
template <int Dim>
bool Placement<Dim>::followWalls(std::uint32_t site, double radius, Vec<Dim>& center) const {
    using Sites = FrontSites<Dim>;
    const auto& bodies = front_.sites.bodies(site);
    if (bodies[0] == Sites::kNoBody) return true;
    const Sphere<Dim>& pivot = sphere(front_.sites.pivot(site));
    const double slack = front_.block.settings.quantum;
    const double rolling = pivot.radius + radius + slack;
    std::size_t wallBodies = 0, wallAt = 0;
    for (std::size_t b = 0; b < Dim - 1; ++b)
        if (bodies[b] >= Sites::kWallBody) ++wallBodies, wallAt = b;
    if (wallBodies == 0) return true;
    TangentPlane<Dim> tangent{};
    double distance = 0;
    // One curved wall is followed to its true nearest point; two (a corner) are taken as planes.
    const int rounds = wallBodies == 1 ? 4 : 1;
    for (int round = 0; round < rounds; ++round) {
        const Vec<Dim> before = center;
        if (wallBodies == 1) {
            if (!front_.block.findWall(pivot.center, center, 2 * radius, 2 * radius, tangent,
                                       distance))
                return false;
            // In a corner another wall may be nearer: the sphere does not rest on that one.
            const TangentPlane<Dim>& known = front_.walls[bodies[wallAt] - Sites::kWallBody];
            if (dot(tangent.normal, known.normal) < 0.8) tangent = known;
            // A flat wall: the center is right as it is.
            const double above = dot(center - tangent.point, tangent.normal);
            if (round == 0 && std::fabs(above - radius - slack) < 0.01 * slack) return true;
        }
        std::array<Contact<Dim>, Dim> contacts;
        contacts[0] = {pivot.center, {}, rolling, false};
        for (std::size_t b = 0; b < Dim - 1; ++b) {
            const std::uint32_t body = bodies[b];
            if (body >= Sites::kWallBody) {
                const TangentPlane<Dim>& plane = wallBodies == 1 && b == wallAt
                                                     ? tangent
                                                     : front_.walls[body - Sites::kWallBody];
                contacts[b + 1] = {plane.point, plane.normal, radius + slack, true};
            } else {
                const Sphere<Dim>& other = sphere(body);
                contacts[b + 1] = {other.center, {}, other.radius + radius + slack, false};
            }
        }
        if (!moveToTouch<Dim>(contacts, slack, radius, center)) return false;
        if (squaredLength(center - before) < 0.01 * slack * slack) break;
    }
    return true;
}

template <int Dim>
bool Placement<Dim>::placeAt(const Vec<Dim>& center, double radius, double beyond) {
    const BlockState<Dim>& block = front_.block;
    if (!block.owns(center, beyond)) return false;
    const double reach = radius + block.lengthsOf(block.sizeAt(center)).reach;
    collect(center, reach, FrontSites<Dim>::kNone);
    double distance = 0;
    hasWall_ = block.findWall(center, center, radius, reach, wall_, distance);
    if (overlaps(center, radius) || (hasWall_ && distance < radius) ||
        !block.sampler->contains(center + block.origin))
        return false;
    add({center, radius});
    return true;
}

template <int Dim>
bool Placement<Dim>::setDown(std::uint32_t site, double radius, double depth, double beyond) {
    const BlockState<Dim>& block = front_.block;
    const FrontSettings<Dim>& settings = block.settings;
    const Vec<Dim>& pivot = sphere(front_.sites.pivot(site)).center;
    const auto limit = static_cast<double>(front_.sites.limit(site));
    // Snapping must not take anything off the depth.
    const double room = radius + (depth > 0 ? depth + settings.quantum : 0);
    Vec<Dim> x = front_.sites.center(site);
    const LocalSize size = block.sizeAt(x);
    const Vec<Dim> ahead = sweeps(settings.order) ? block.advance(x) : normalized(x - pivot);
    x += ahead * (radius - limit);
    Vec<Dim> resting;
    if (radius <= limit && front_.sites.restingCenter(site, radius, resting)) x = resting;
    // Away until it is clear of all; every step leaves some sphere or the wall behind.
    for (int step = 0;; ++step) {
        double most = 0;
        block.cells.near(x, radius + settings.quantum, [&](std::uint32_t i) {
            const Sphere<Dim>& s = sphere(i);
            const double least = s.radius + radius + 1.5 * settings.quantum;
            const Vec<Dim> from = x - s.center;
            const double along = dot(from, ahead);
            const double inside = least * least - squaredLength(from);
            if (inside > 0) most = std::max(most, std::sqrt(along * along + inside) - along);
            return true;
        });
        Vec<Dim> by = ahead * (most > 0 ? most + settings.quantum : 0.0);
        TangentPlane<Dim> plane;
        double distance = room;
        if (most == 0 && block.findWall(pivot, x, room, room, plane, distance)) {
            // All that the last layers ask for would lie side by side at the wall.
            if (beyond > 0 && dot(plane.normal, ahead) < 0) return false;
            by = plane.normal * (room + 2 * settings.quantum - dot(x - plane.point, plane.normal));
        } else if (most == 0) {
            break;
        }
        x += by;
        if (step == kSetDownSteps || !block.owns(x, beyond)) return false;
    }
    const Vec<Dim> center = block.snapped(x);
    if (block.local && !LocalLengths<Dim>::areAlike(size, block.sizeAt(center))) return false;
    return placeAt(center, radius, beyond);
}

template class Placement<2>;
template class Placement<3>;

}  // namespace vdbpack
