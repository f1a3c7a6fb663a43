#include "vdbpack/measure/morphometry/ridge.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// A voxel is on the ridge if the distance rises less than this share of what it does on a slope
/// behind a single wall: 0.88 means walls that face each other at more than 57 degrees.
constexpr float kSlack = 0.12f;
/// Walls that lead off in nearly one direction (less than 32 degrees apart) do not stop a ball:
/// over a voxel it cannot be wrong by more than 0.06, but noise in their distances could.
constexpr float kParallel = 0.15f;

Place along(const Place& x, const Place& direction, float t) {
    return {x[0] + t * direction[0], x[1] + t * direction[1], x[2] + t * direction[2]};
}

/// How far a ball at `x` of radius `radius` may move along `direction`, growing by `rate` a
/// voxel of way, before it meets the surface at `wall`; at most `limit`.
float freeWay(const Clearance& wall, float radius, const Place& direction, float rate,
              float limit) {
    const float toward = dot(direction, wall.direction);
    float way = limit;
    if (wall.flat) {
        if (rate - toward < kParallel) return limit;
        way = (wall.distance - radius) / (rate - toward);
    } else {
        // |x + t d - q|^2 = (radius + rate t)^2, without the term of t^2: it only helps.
        const float closing = radius * rate - wall.distance * toward;
        if (closing < kParallel * wall.distance) return limit;
        way = (wall.distance * wall.distance - radius * radius) / (2 * closing);
    }
    return std::clamp(way, 0.0f, limit);
}

}  // namespace

/// The clearance to the surface point nearest to a voxel.
Clearance Ridge::at(const Place& x, std::size_t voxel, float side) const {
    return clearance(x, surface_.points[surface_.nearest[voxel]], side);
}

/// As `clearance`, for a surface that may bend: the foot of `x` on the tangent plane is moved
/// onto the surface by the distance there. A point of the surface, it can be too far from `x`
/// but not too near, whatever the surface looks like.
Clearance Ridge::refined(const Place& x, std::uint32_t index, float side) const {
    constexpr float kReach = 1.5f;  // voxels from the surface point
    const SurfacePoint& point = surface_.points[index];
    const Place& n = point.normal;
    const Place w{x[0] - point.at[0], x[1] - point.at[1], x[2] - point.at[2]};
    const float square = dot(w, w);
    const float height = dot(w, n);
    if (side * height > 0 && square - height * height <= kReach * kReach) {
        Place foot = along(x, n, -height);
        float value = 0;
        if (interpolate(foot, value)) {
            foot = along(foot, n, -value);
            const Place v{x[0] - foot[0], x[1] - foot[1], x[2] - foot[2]};
            const float s = dot(v, v);
            if (s <= square && s > 0) {
                const float length = std::sqrt(s);
                return {length, {v[0] / length, v[1] / length, v[2] / length}, true};
            }
        }
    }
    Clearance far = clearance(x, point, side);
    if (far.flat) {
        const float length = std::sqrt(square);
        far = {length, {w[0] / length, w[1] / length, w[2] / length}, false};
    }
    return far;
}

/// The distance at `x` in voxels, trilinear less what the interpolation gains where the
/// distance bends; false outside the image or a voxel off the surface.
bool Ridge::interpolate(const Place& x, float& value) const {
    std::array<std::size_t, 3> low{};
    Place t{};
    for (std::size_t j = 0; j < 3; ++j) {
        const float floor = std::floor(x[j]);
        if (!(floor >= 0) || !(floor + 1 < static_cast<float>(size_[j]))) return false;
        low[j] = static_cast<std::size_t>(floor);
        t[j] = x[j] - floor;
    }
    const auto row = static_cast<std::size_t>(size_[0]);
    const std::array<std::size_t, 3> stride{1, row, row * static_cast<std::size_t>(size_[1])};
    const float* d = &image_.distance[low[2] * stride[2] + low[1] * stride[1] + low[0]];
    const auto between = [](float a, float b, float s) { return a + s * (b - a); };
    const auto line = [&](const float* p) { return between(p[0], p[1], t[0]); };
    value = between(between(line(d), line(d + stride[1]), t[1]),
                    between(line(d + stride[2]), line(d + stride[2] + stride[1]), t[1]), t[2]);
    const auto h = static_cast<float>(image_.voxelSize);
    if (!(std::abs(value) < h)) return false;
    for (std::size_t j = 0; j < 3; ++j) {
        if (low[j] == 0 || low[j] + 2 >= static_cast<std::size_t>(size_[j])) continue;
        // Along the nearest of the four edges of the cell.
        const float* p = d;
        for (std::size_t k = 0; k < 3; ++k)
            if (k != j && t[k] > 0.5f) p += stride[k];
        value -= 0.5f * t[j] * (1 - t[j]) *
                 boundedBend(*(p - stride[j]), p[0], p[stride[j]], p[2 * stride[j]], h);
    }
    value /= h;
    return true;
}

/// How far along `direction` a center stays in the image; at most `limit`.
float Ridge::wayInside(const Place& x, const Place& direction, float limit) const {
    for (std::size_t j = 0; j < 3; ++j) {
        const float room = direction[j] > 0 ? static_cast<float>(size_[j] - 1) - x[j] : x[j];
        if (std::abs(direction[j]) * limit > room)
            limit = std::max(room, 0.0f) / std::abs(direction[j]);
    }
    return limit;
}

/// Whether the distance rises by less than on a slope behind one wall, from a voxel to the next one
/// away from its surface point.
/// @param way  set to how far that is, voxels.
bool Ridge::isOnRidge(const Voxel& x, std::size_t voxel, float side, float& way) const {
    const Place center{static_cast<float>(x[0]), static_cast<float>(x[1]),
                       static_cast<float>(x[2])};
    const Clearance own = at(center, voxel, side);
    const Place u = own.direction;
    const float most = std::max({std::abs(u[0]), std::abs(u[1]), std::abs(u[2])});
    Voxel next{};
    way = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const std::int64_t step = std::lround(u[j] / most);
        next[j] = x[j] + step;
        way += static_cast<float>(step) * u[j];
    }
    if (!inside(next[0], next[1], next[2])) return true;
    const std::size_t there = index(next[0], next[1], next[2]);
    const Place place{static_cast<float>(next[0]), static_cast<float>(next[1]),
                      static_cast<float>(next[2])};
    return solid(there) != solid(voxel) ||
           !(at(place, there, side).distance >= own.distance + (1 - kSlack) * way);
}

/// The surface points nearest to the voxels around one, except its own `first`: they may stop a
/// ball that moves away from that.
Ridge::Walls Ridge::wallsAround(const Voxel& x, std::uint32_t first) const {
    Walls walls;
    Voxel low{}, end{};
    for (std::size_t j = 0; j < 3; ++j) {
        low[j] = std::max<std::int64_t>(x[j] - 1, 0);
        end[j] = std::min(x[j] + 2, size_[j]);
    }
    for (std::int64_t k = low[2]; k < end[2]; ++k)
        for (std::int64_t j = low[1]; j < end[1]; ++j)
            for (std::int64_t i = low[0]; i < end[0]; ++i) {
                const std::uint32_t wall = surface_.nearest[index(i, j, k)];
                const auto last = walls.points.begin() + static_cast<std::ptrdiff_t>(walls.count);
                if (wall != first && std::find(walls.points.begin(), last, wall) == last)
                    walls.points[walls.count++] = wall;
            }
    return walls;
}

/// Moves a ball away from its surface point `first`, by `way` at most, up to a second wall, then
/// away from both.
void Ridge::moveToMiddle(std::uint32_t first, const Walls& walls, float way, float side,
                         RidgeBall& ball) const {
    const Clearance own = refined(ball.center, first, side);
    const Place u = own.direction;
    float radius = own.distance;
    std::uint32_t second = first;
    Place other{};
    float limit = wayInside(ball.center, u, way);
    for (std::size_t i = 0; i < walls.count; ++i) {
        const Clearance wall = refined(ball.center, walls.points[i], side);
        const float t = freeWay(wall, radius, u, 1, limit);
        if (t < limit) {
            limit = t;
            second = walls.points[i];
            other = wall.direction;
        }
    }
    ball.center = along(ball.center, u, limit);
    radius += limit;
    // On between two walls that do not face each other squarely: rods with edges, corners.
    const Place sum{u[0] + other[0], u[1] + other[1], u[2] + other[2]};
    const float length = std::sqrt(dot(sum, sum));
    if (second != first && length > 0.3f) {
        const Place v{sum[0] / length, sum[1] / length, sum[2] / length};
        const float rate = length * 0.5f;  // cosine of half the angle between the two
        limit = wayInside(ball.center, v, 1);
        for (std::size_t i = 0; i < walls.count; ++i)
            if (walls.points[i] != second)
                limit =
                    freeWay(refined(ball.center, walls.points[i], side), radius, v, rate, limit);
        ball.center = along(ball.center, v, limit);
        radius += rate * limit;
    }
    ball.radius = radius;
}

/// The radius that the surface points nearest to the voxels around a ball's center allow.
float Ridge::cappedRadius(const RidgeBall& ball, float side) const {
    float radius = ball.radius;
    Voxel low{};
    for (std::size_t j = 0; j < 3; ++j)
        low[j] = static_cast<std::int64_t>(std::floor(ball.center[j]));
    std::uint32_t last = ~std::uint32_t{0};
    for (int corner = 0; corner < 8; ++corner) {
        const std::int64_t i = low[0] + (corner & 1), j = low[1] + (corner >> 1 & 1),
                           k = low[2] + (corner >> 2);
        if (!inside(i, j, k)) continue;
        const std::uint32_t wall = surface_.nearest[index(i, j, k)];
        if (wall != last) radius = std::min(radius, refined(ball.center, wall, side).distance);
        last = wall;
    }
    return radius;
}

/// The ball of a voxel of the ridge; false if the voxel is not on it.
bool Ridge::grow(const Voxel& x, RidgeBall& ball) const {
    const std::size_t voxel = index(x[0], x[1], x[2]);
    const float side = solid(voxel) ? -1.0f : 1.0f;
    float way = 0;
    if (!isOnRidge(x, voxel, side, way)) return false;
    const std::uint32_t first = surface_.nearest[voxel];
    ball.center = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
    moveToMiddle(first, wallsAround(x, first), way, side, ball);
    ball.radius = cappedRadius(ball, side);
    return ball.radius > 0;
}

void Ridge::collect(std::int64_t z, bool solidBalls, std::vector<RidgeBall>& balls) const {
    for (std::int64_t y = 0; y < size_[1]; ++y)
        for (std::int64_t x = 0; x < size_[0]; ++x) {
            RidgeBall ball;
            if (solid(index(x, y, z)) != solidBalls) continue;
            if (grow({x, y, z}, ball)) balls.push_back(ball);
        }
}

float Ridge::ownThickness(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t voxel) const {
    const Place p{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    return 2 * at(p, voxel, solid(voxel) ? -1.0f : 1.0f).distance;
}

}  // namespace vdbpack
