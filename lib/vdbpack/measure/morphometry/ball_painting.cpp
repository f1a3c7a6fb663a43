#include "vdbpack/measure/morphometry/ball_painting.h"

#include "vdbpack/core/lanes.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Balls reach this much farther, voxels: those of one wall stand a voxel apart, and between them
/// lie strips of up to 1 / (8 radius) that none of them covers.
constexpr float kCover = 0.1f;
constexpr std::int64_t kBrick = 8;  // voxels along an edge: a plane of it is one word of bits
static_assert(kBrick == kLanes);
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

    void paint(const RidgeBall& ball, std::vector<float>& thickness) {
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

    /// The voxels of a plane of a brick within the square root of `square` of `c` in x and y.
    static std::uint64_t disk(const Place& corner, const Place& c, float square) {
        if (square < 0) return 0;
        const float x = c[0] - corner[0];
        const Float8 dy = Float8{0, 1, 2, 3, 4, 5, 6, 7} - (c[1] - corner[1]);
        const Float8 room = square - dy * dy;
        const Float8 half = squareRoot(larger(room, 0.0f));
        const Float8 low = larger(x - half, 0.0f), high = smaller(x + half, kBrick - 1.0f);
        const Int8 first = roundedUp(low), last = __builtin_convertvector(high, Int8);
        const Int8 one = Int8{} + 1;
        const Int8 rows = ((one + one) << (last & 7)) - (one << (first & 7));
        const Int8 inside = rows & (room >= 0.0f) & (low <= high) & (first <= last);
        std::uint64_t bits = 0;
        for (std::size_t j = 0; j < kLanes; ++j)
            bits |= static_cast<std::uint64_t>(static_cast<std::uint32_t>(inside[j])) << 8 * j;
        return bits;
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
            if (covered == 0) covered = plane & disk(corner, c, square - dz * dz);
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

}  // namespace

template <class Visit>
void BallPainting::forEachTile(const RidgeBall& ball, const Visit& visit) const {
    std::array<std::int64_t, 3> from{}, to{};
    for (std::size_t j = 0; j < 3; ++j) {
        const float reach = ball.radius + kCover;
        from[j] = std::max<std::int64_t>(
                      static_cast<std::int64_t>(std::ceil(ball.center[j] - reach)), 0) /
                  kTile;
        to[j] =
            std::min(static_cast<std::int64_t>(std::floor(ball.center[j] + reach)), size_[j] - 1) /
            kTile;
    }
    for (std::int64_t z = from[2]; z <= to[2]; ++z)
        for (std::int64_t y = from[1]; y <= to[1]; ++y)
            for (std::int64_t x = from[0]; x <= to[0]; ++x)
                visit(static_cast<std::size_t>((z * tiles_[1] + y) * tiles_[0] + x));
}

BallPainting::BallPainting(const VoxelImage& image, std::vector<RidgeBall> balls)
    : size_(image.size), balls_(std::move(balls)) {
    tbb::parallel_sort(balls_.begin(), balls_.end(), [](const RidgeBall& a, const RidgeBall& b) {
        if (a.radius != b.radius) return a.radius > b.radius;
        return a.center < b.center;
    });
    for (std::size_t j = 0; j < 3; ++j) tiles_[j] = (size_[j] + kTile - 1) / kTile;
    start_.assign(tiles() + 1, 0);
    for (const RidgeBall& ball : balls_) forEachTile(ball, [&](std::size_t t) { ++start_[t + 1]; });
    for (std::size_t t = 0; t < tiles(); ++t) start_[t + 1] += start_[t];
    member_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < balls_.size(); ++i)
        forEachTile(balls_[i],
                    [&](std::size_t t) { member_[next[t]++] = static_cast<std::uint32_t>(i); });
}

std::vector<Leftover> BallPainting::paint(std::size_t tile, const VoxelImage& image,
                                          const Ridge& ridge, bool solid,
                                          std::vector<float>& thickness) const {
    const auto t = static_cast<std::int64_t>(tile);
    const std::array<std::int64_t, 3> low{t % tiles_[0] * kTile, t / tiles_[0] % tiles_[1] * kTile,
                                          t / (tiles_[0] * tiles_[1]) * kTile};
    Tile voxels(image, ridge, low, solid);
    for (std::size_t i = start_[tile]; i < start_[tile + 1] && !voxels.done(); ++i)
        voxels.paint(balls_[member_[i]], thickness);
    std::vector<Leftover> left;
    voxels.forEachLeft([&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t voxel) {
        left.push_back({x, y, z, voxel});
    });
    return left;
}

}  // namespace vdbpack
