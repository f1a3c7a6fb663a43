#include "vdbpack/measure/morphometry/local_thickness.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

namespace {

/// Balls reach this much farther, voxels: those of one wall stand a voxel apart, and between them
/// lie strips of up to 1 / (8 radius) that none of them covers.
constexpr float kCover = 0.1f;
/// A voxel is on the ridge if the distance rises less than this share of what it does on a slope
/// behind a single wall: 0.88 means walls that face each other at more than 57 degrees.
constexpr float kSlack = 0.12f;
/// Walls that lead off in nearly one direction (less than 32 degrees apart) do not stop a ball:
/// over a voxel it cannot be wrong by more than 0.06, but noise in their distances could.
constexpr float kParallel = 0.15f;

struct Ball {
    Place center{};
    float radius = 0;
    std::uint32_t solid = 0;
};

Place along(const Place& x, const Place& direction, float t) {
    return {x[0] + t * direction[0], x[1] + t * direction[1], x[2] + t * direction[2]};
}

/// Finds the balls of one image.
class Ridge {
public:
    Ridge(const VoxelImage& image, const SurfaceDistance& surface)
        : image_(image), surface_(surface), size_{image.size} {}

    bool solid(std::size_t voxel) const { return image_.distance[voxel] < 0; }
    bool inTotal(std::size_t voxel) const {
        return image_.label.empty() || image_.label[voxel] != 0;
    }

    /// The balls centered near the voxels of slice `z`, in their order.
    void collect(std::int64_t z, std::vector<Ball>& balls) const {
        for (std::int64_t y = 0; y < size_[1]; ++y)
            for (std::int64_t x = 0; x < size_[0]; ++x) {
                Ball ball;
                if (grow(x, y, z, index(x, y, z), ball)) balls.push_back(ball);
            }
    }

    /// The clearance to the surface point nearest to a voxel.
    Clearance at(const Place& x, std::size_t voxel, float side) const {
        return clearance(x, surface_.points[surface_.nearest[voxel]], side);
    }

    /// As `clearance`, for a surface that may bend: the foot of `x` on the tangent plane is moved
    /// onto the surface by the distance there. A point of the surface, it can be too far from `x`
    /// but not too near, whatever the surface looks like.
    Clearance refined(const Place& x, std::uint32_t index, float side) const {
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

    float ownThickness(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t voxel) const {
        const Place p{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        return 2 * at(p, voxel, solid(voxel) ? -1.0f : 1.0f).distance;
    }

private:
    /// The distance at `x` in voxels, trilinear less what the interpolation gains where the
    /// distance bends; false outside the image or a voxel off the surface.
    bool interpolate(const Place& x, float& value) const {
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
    std::size_t index(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>((z * size_[1] + y) * size_[0] + x);
    }
    bool inside(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return x >= 0 && y >= 0 && z >= 0 && x < size_[0] && y < size_[1] && z < size_[2];
    }

    /// How far a ball at `x` of radius `radius` may move along `direction`, growing by `rate` a
    /// voxel of way, before it meets the surface at `wall`; at most `limit`.
    static float freeWay(const Clearance& wall, float radius, const Place& direction, float rate,
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

    /// How far along `direction` a center stays in the image; at most `limit`.
    float wayInside(const Place& x, const Place& direction, float limit) const {
        for (std::size_t j = 0; j < 3; ++j) {
            const float room = direction[j] > 0 ? static_cast<float>(size_[j] - 1) - x[j] : x[j];
            if (std::abs(direction[j]) * limit > room)
                limit = std::max(room, 0.0f) / std::abs(direction[j]);
        }
        return limit;
    }

    /// The ball of a voxel of the ridge; false if the voxel is not on it.
    bool grow(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t voxel, Ball& ball) const {
        const float side = solid(voxel) ? -1.0f : 1.0f;
        Place center{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        Clearance own = at(center, voxel, side);
        Place u = own.direction;
        const float most = std::max({std::abs(u[0]), std::abs(u[1]), std::abs(u[2])});
        std::array<std::int64_t, 3> step{};
        float way = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            step[j] = std::lround(u[j] / most);
            way += static_cast<float>(step[j]) * u[j];
        }
        const std::int64_t x1 = x + step[0], y1 = y + step[1], z1 = z + step[2];
        if (inside(x1, y1, z1)) {
            const std::size_t next = index(x1, y1, z1);
            const Place there{static_cast<float>(x1), static_cast<float>(y1),
                              static_cast<float>(z1)};
            if (solid(next) == solid(voxel) &&
                at(there, next, side).distance >= own.distance + (1 - kSlack) * way)
                return false;
        }

        // The points that may stop it: those nearest to the voxels around.
        std::array<std::uint32_t, 27> walls;
        std::size_t count = 0;
        const std::uint32_t first = surface_.nearest[voxel];
        own = refined(center, first, side);
        u = own.direction;
        for (std::int64_t k = std::max<std::int64_t>(z - 1, 0); k < std::min(z + 2, size_[2]); ++k)
            for (std::int64_t j = std::max<std::int64_t>(y - 1, 0); j < std::min(y + 2, size_[1]);
                 ++j)
                for (std::int64_t i = std::max<std::int64_t>(x - 1, 0);
                     i < std::min(x + 2, size_[0]); ++i) {
                    const std::uint32_t wall = surface_.nearest[index(i, j, k)];
                    const auto end = walls.begin() + static_cast<std::ptrdiff_t>(count);
                    if (wall != first && std::find(walls.begin(), end, wall) == end)
                        walls[count++] = wall;
                }
        float radius = own.distance;
        std::uint32_t second = first;
        Place other{};
        float limit = wayInside(center, u, way);
        for (std::size_t i = 0; i < count; ++i) {
            const Clearance wall = refined(center, walls[i], side);
            const float t = freeWay(wall, radius, u, 1, limit);
            if (t < limit) {
                limit = t;
                second = walls[i];
                other = wall.direction;
            }
        }
        center = along(center, u, limit);
        radius += limit;
        // On between two walls that do not face each other squarely: rods with edges, corners.
        const Place sum{u[0] + other[0], u[1] + other[1], u[2] + other[2]};
        const float length = std::sqrt(dot(sum, sum));
        if (second != first && length > 0.3f) {
            const Place v{sum[0] / length, sum[1] / length, sum[2] / length};
            const float rate = length * 0.5f;  // cosine of half the angle between the two
            limit = wayInside(center, v, 1);
            for (std::size_t i = 0; i < count; ++i)
                if (walls[i] != second)
                    limit = freeWay(refined(center, walls[i], side), radius, v, rate, limit);
            center = along(center, v, limit);
            radius += rate * limit;
        }

        // No ball is larger than the points nearest to the voxels around its center allow.
        std::array<std::int64_t, 3> low{};
        for (std::size_t j = 0; j < 3; ++j)
            low[j] = static_cast<std::int64_t>(std::floor(center[j]));
        std::uint32_t last = ~std::uint32_t{0};
        for (int corner = 0; corner < 8; ++corner) {
            const std::int64_t i = low[0] + (corner & 1), j = low[1] + (corner >> 1 & 1),
                               k = low[2] + (corner >> 2);
            if (!inside(i, j, k)) continue;
            const std::uint32_t wall = surface_.nearest[index(i, j, k)];
            if (wall != last) radius = std::min(radius, refined(center, wall, side).distance);
            last = wall;
        }
        ball.center = center;
        ball.radius = radius;
        ball.solid = solid(voxel) ? 1 : 0;
        return radius > 0;
    }

    const VoxelImage& image_;
    const SurfaceDistance& surface_;
    std::array<std::int64_t, 3> size_;
};

constexpr std::int64_t kBrick = 8;   // voxels along an edge: a plane of it is one word of bits
constexpr std::int64_t kBricks = 8;  // bricks along an edge of a tile
constexpr std::int64_t kTile = kBrick * kBricks;

/// 64 x 64 x 64 voxels that know which of their voxels no ball has covered yet. As balls come by
/// falling radius, the first one to cover a voxel is its largest, and what is left to look at
/// shrinks with every ball.
class Tile {
public:
    Tile(const VoxelImage& image, const Ridge& ridge, const std::array<std::int64_t, 3>& low,
         bool solid)
        : size_(image.size), low_(low), bits_(kBricks * kBricks * kBricks * kBrick) {
        for (std::int64_t z = 0; z < extent(2); ++z)
            for (std::int64_t y = 0; y < extent(1); ++y)
                for (std::int64_t x = 0; x < extent(0); ++x) {
                    const std::size_t voxel = index(x, y, z);
                    if (ridge.solid(voxel) != solid || !ridge.inTotal(voxel)) continue;
                    const std::size_t b = brick(x / kBrick, y / kBrick, z / kBrick);
                    bits_[b * kBrick + static_cast<std::size_t>(z % kBrick)] |=
                        std::uint64_t{1} << (y % kBrick * kBrick + x % kBrick);
                    left_[b / kBricks] |= static_cast<std::uint8_t>(1u << b % kBricks);
                    ++open_;
                }
    }

    bool done() const { return open_ == 0; }

    void paint(const Ball& ball, std::vector<float>& thickness) {
        const float reach = ball.radius + kCover;
        Place c;
        std::array<std::int64_t, 3> from{}, to{};
        for (std::size_t j = 0; j < 3; ++j) {
            c[j] = ball.center[j] - static_cast<float>(low_[j]);
            from[j] = std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(c[j] - reach)), 0);
            to[j] = std::min(static_cast<std::int64_t>(std::floor(c[j] + reach)), extent(j) - 1);
            if (from[j] > to[j]) return;
        }
        const auto columns =
            static_cast<std::uint32_t>((2u << to[0] / kBrick) - (1u << from[0] / kBrick));
        for (std::int64_t bz = from[2] / kBrick; bz <= to[2] / kBrick; ++bz)
            for (std::int64_t by = from[1] / kBrick; by <= to[1] / kBrick; ++by) {
                std::uint32_t open = left_[static_cast<std::size_t>(bz * kBricks + by)] & columns;
                for (std::int64_t bx = 0; open != 0; ++bx, open >>= 1)
                    if (open & 1u) paintBrick(bx, by, bz, c, reach, 2 * ball.radius, thickness);
            }
    }

    /// Calls `visit(x, y, z, voxel)` for the voxels that no ball covered.
    template <class Visit>
    void forEachLeft(const Visit& visit) const {
        for (std::int64_t z = 0; z < extent(2); ++z)
            for (std::int64_t y = 0; y < extent(1); ++y)
                for (std::int64_t x = 0; x < extent(0); ++x) {
                    const std::size_t b = brick(x / kBrick, y / kBrick, z / kBrick);
                    const std::uint64_t plane =
                        bits_[b * kBrick + static_cast<std::size_t>(z % kBrick)];
                    if (plane >> (y % kBrick * kBrick + x % kBrick) & 1)
                        visit(low_[0] + x, low_[1] + y, low_[2] + z, index(x, y, z));
                }
    }

private:
    std::int64_t extent(std::size_t j) const { return std::min(size_[j] - low_[j], kTile); }
    std::size_t index(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>(((low_[2] + z) * size_[1] + low_[1] + y) * size_[0] +
                                        low_[0] + x);
    }
    static std::size_t brick(std::int64_t bx, std::int64_t by, std::int64_t bz) {
        return static_cast<std::size_t>((bz * kBricks + by) * kBricks + bx);
    }

    /// The voxels of a plane of a brick within the square root of `square` of `c` in x and y; those
    /// of `plane` for sure, others perhaps.
    static std::uint64_t disk(const Place& corner, const Place& c, float square,
                              std::uint64_t plane) {
        std::uint64_t inside = 0;
        if (square < 0) return inside;
        const float x = c[0] - corner[0], y = c[1] - corner[1];
        for (int j = 0; j < kBrick; ++j) {
            if ((plane >> j * kBrick & 0xFF) == 0) continue;
            const float dy = static_cast<float>(j) - y;
            const float room = square - dy * dy;
            if (room < 0) continue;
            const float half = std::sqrt(room);
            const float low = std::max(x - half, 0.0f), high = std::min(x + half, kBrick - 1.0f);
            if (!(low <= high)) continue;
            const int first = static_cast<int>(std::ceil(low)), last = static_cast<int>(high);
            if (first > last) continue;
            inside |= ((std::uint64_t{2} << last) - (std::uint64_t{1} << first)) << j * kBrick;
        }
        return inside;
    }

    void paintBrick(std::int64_t bx, std::int64_t by, std::int64_t bz, const Place& c, float reach,
                    float value, std::vector<float>& thickness) {
        const Place corner{static_cast<float>(bx * kBrick), static_cast<float>(by * kBrick),
                           static_cast<float>(bz * kBrick)};
        const float square = reach * reach;
        float nearest = 0, farthest = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const float below = corner[j] - c[j], above = c[j] - corner[j] - (kBrick - 1);
            const float out = std::max({below, above, 0.0f});
            const float over = std::max(below, above) + (kBrick - 1);
            nearest += out * out;
            farthest += over * over;
        }
        if (nearest > square) return;
        const std::size_t b = brick(bx, by, bz);
        std::uint64_t rest = 0;
        for (std::int64_t k = 0; k < kBrick; ++k) {
            std::uint64_t& plane = bits_[b * kBrick + static_cast<std::size_t>(k)];
            if (plane == 0) continue;
            const float dz = corner[2] + static_cast<float>(k) - c[2];
            std::uint64_t covered = farthest <= square ? plane : 0;
            if (covered == 0) covered = plane & disk(corner, c, square - dz * dz, plane);
            plane &= ~covered;
            rest |= plane;
            while (covered != 0) {
                const int bit = __builtin_ctzll(covered);
                covered &= covered - 1;
                thickness[index(bx * kBrick + bit % kBrick, by * kBrick + bit / kBrick,
                                bz * kBrick + k)] = value;
                --open_;
            }
        }
        if (rest == 0) left_[b / kBricks] &= static_cast<std::uint8_t>(~(1u << b % kBricks));
    }

    std::array<std::int64_t, 3> size_, low_;
    std::vector<std::uint64_t> bits_;                     // brick by brick, plane by plane
    std::array<std::uint8_t, kBricks * kBricks> left_{};  // rows of bricks with open voxels
    std::int64_t open_ = 0;
};

struct Leftover {
    std::int64_t x, y, z;
    std::size_t voxel;
};

/// All balls of one phase by falling radius, each tile's in a list of its own.
class TiledBalls {
public:
    TiledBalls(const VoxelImage& image, std::vector<Ball> balls)
        : size_(image.size), balls_(std::move(balls)) {
        tbb::parallel_sort(balls_.begin(), balls_.end(), [](const Ball& a, const Ball& b) {
            if (a.radius != b.radius) return a.radius > b.radius;
            return a.center < b.center;
        });
        for (std::size_t j = 0; j < 3; ++j) tiles_[j] = (size_[j] + kTile - 1) / kTile;
        start_.assign(count() + 1, 0);
        for (const Ball& ball : balls_) forEachTile(ball, [&](std::size_t t) { ++start_[t + 1]; });
        for (std::size_t t = 0; t < count(); ++t) start_[t + 1] += start_[t];
        member_.resize(start_.back());
        std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
        for (std::size_t i = 0; i < balls_.size(); ++i)
            forEachTile(balls_[i],
                        [&](std::size_t t) { member_[next[t]++] = static_cast<std::uint32_t>(i); });
    }

    std::size_t count() const {
        return static_cast<std::size_t>(tiles_[0] * tiles_[1] * tiles_[2]);
    }
    std::array<std::int64_t, 3> low(std::size_t tile) const {
        const auto t = static_cast<std::int64_t>(tile);
        return {t % tiles_[0] * kTile, t / tiles_[0] % tiles_[1] * kTile,
                t / (tiles_[0] * tiles_[1]) * kTile};
    }
    void paint(std::size_t t, Tile& tile, std::vector<float>& thickness) const {
        for (std::size_t i = start_[t]; i < start_[t + 1] && !tile.done(); ++i)
            tile.paint(balls_[member_[i]], thickness);
    }

private:
    template <class Visit>
    void forEachTile(const Ball& ball, const Visit& visit) const {
        std::array<std::int64_t, 3> from{}, to{};
        for (std::size_t j = 0; j < 3; ++j) {
            const float reach = ball.radius + kCover;
            from[j] = std::max<std::int64_t>(
                          static_cast<std::int64_t>(std::ceil(ball.center[j] - reach)), 0) /
                      kTile;
            to[j] = std::min(static_cast<std::int64_t>(std::floor(ball.center[j] + reach)),
                             size_[j] - 1) /
                    kTile;
        }
        for (std::int64_t z = from[2]; z <= to[2]; ++z)
            for (std::int64_t y = from[1]; y <= to[1]; ++y)
                for (std::int64_t x = from[0]; x <= to[0]; ++x)
                    visit(static_cast<std::size_t>((z * tiles_[1] + y) * tiles_[0] + x));
    }

    std::array<std::int64_t, 3> size_, tiles_{};
    std::vector<Ball> balls_;
    std::vector<std::size_t> start_;
    std::vector<std::uint32_t> member_;
};

/// The mean of the neighbors of its phase that have a thickness; 0 if none has.
float neighborsMean(const VoxelImage& image, const Leftover& at,
                    const std::vector<float>& thickness) {
    const auto& n = image.size;
    const bool solid = image.distance[at.voxel] < 0;
    double sum = 0;
    int count = 0;
    for (std::int64_t z = std::max<std::int64_t>(at.z - 1, 0); z < std::min(at.z + 2, n[2]); ++z)
        for (std::int64_t y = std::max<std::int64_t>(at.y - 1, 0); y < std::min(at.y + 2, n[1]);
             ++y)
            for (std::int64_t x = std::max<std::int64_t>(at.x - 1, 0); x < std::min(at.x + 2, n[0]);
                 ++x) {
                const auto voxel = static_cast<std::size_t>((z * n[1] + y) * n[0] + x);
                if ((image.distance[voxel] < 0) != solid || !(thickness[voxel] > 0)) continue;
                sum += double{thickness[voxel]};
                ++count;
            }
    return count > 0 ? static_cast<float>(sum / count) : 0.0f;
}

void fillLeft(const VoxelImage& image, const Ridge& ridge, std::vector<Leftover> left,
              std::vector<float>& thickness) {
    std::vector<float> value;
    while (!left.empty()) {
        value.assign(left.size(), 0.0f);
        tbb::parallel_for(std::size_t{0}, left.size(), [&](std::size_t i) {
            value[i] = neighborsMean(image, left[i], thickness);
        });
        std::vector<Leftover> still;
        for (std::size_t i = 0; i < left.size(); ++i) {
            thickness[left[i].voxel] = value[i];
            if (!(value[i] > 0)) still.push_back(left[i]);
        }
        if (still.size() == left.size()) break;
        left.swap(still);
    }
    for (const Leftover& l : left) thickness[l.voxel] = ridge.ownThickness(l.x, l.y, l.z, l.voxel);
}

}  // namespace

std::vector<float> localThickness(const VoxelImage& image, const SurfaceDistance& surface) {
    const Ridge ridge(image, surface);
    const auto slices = static_cast<std::size_t>(image.size[2]);
    std::vector<float> thickness(image.voxels(), 0.0f);
    std::vector<std::vector<Ball>> found(slices);
    tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t z) {
        ridge.collect(static_cast<std::int64_t>(z), found[z]);
    });
    for (const bool solid : {false, true}) {
        std::vector<Ball> balls;
        for (const auto& slice : found)
            for (const Ball& ball : slice)
                if ((ball.solid != 0) == solid) balls.push_back(ball);
        const TiledBalls tiled(image, std::move(balls));
        std::vector<std::vector<Leftover>> missed(tiled.count());
        tbb::parallel_for(std::size_t{0}, tiled.count(), [&](std::size_t t) {
            Tile tile(image, ridge, tiled.low(t), solid);
            tiled.paint(t, tile, thickness);
            tile.forEachLeft(
                [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t voxel) {
                    missed[t].push_back({x, y, z, voxel});
                });
        });
        std::vector<Leftover> left;
        for (const auto& m : missed) left.insert(left.end(), m.begin(), m.end());
        fillLeft(image, ridge, std::move(left), thickness);
    }
    return thickness;
}

}  // namespace vdbpack
