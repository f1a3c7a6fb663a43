#include "vdbpack/field/band/leaf_distances.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Rounding of a plane in single precision within a leaf's reach, voxels.
constexpr float kRounding = 4e-6f;
/// Added to distances within which blocks are looked at, so that rounding leaves none out.
constexpr float kSlack = 1e-3f;
/// Half the diagonal of the voxels of a block of 4^3 and of 2^3, rounded up.
constexpr float kRadius4 = 2.5981f, kRadius2 = 0.86603f;

// Signs of the coordinates of the eight lanes about the middle: lane = 4 x + 2 y + z.
constexpr Float8 kX{-1, -1, -1, -1, 1, 1, 1, 1};
constexpr Float8 kY{-1, -1, 1, 1, -1, -1, 1, 1};
constexpr Float8 kZ{-1, 1, -1, 1, -1, 1, -1, 1};

struct Float3 {
    float x, y, z;
};
Float3 single(const Vec<3>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

/// A linear function over a leaf: value at the center, and its change to the lanes. Lanes are
/// blocks of 4^3 at a distance of 2 along each axis, of 2^3 at 1, voxels at 1/2.
struct Linear {
    float atCenter;
    Float8 step;    ///< at a distance of 1
    float support;  ///< most change within a distance of 1 along each axis

    Linear(const Vec<3>& gradient, double value) : atCenter(static_cast<float>(value)) {
        const Float3 g = single(gradient);
        step = kX * g.x + kY * g.y + kZ * g.z;
        support = std::fabs(g.x) + std::fabs(g.y) + std::fabs(g.z);
    }
    Float8 blocks4() const { return step * 2.0f + atCenter; }
    Float8 blocks2(float at) const { return step + at; }
    Float8 voxels(float at) const { return step * 0.5f + at; }
};

constexpr float kHalf4 = 1.5f, kHalf2 = 0.5f;  ///< from the middle of a block to its last voxels

/// The coordinates of the lanes relative to a point.
struct Lanes {
    Float8 x, y, z;
    Lanes(const Float3& middle, float distance)
        : x(kX * distance + middle.x), y(kY * distance + middle.y), z(kZ * distance + middle.z) {}
    Float3 at(std::size_t l) const { return {x[l], y[l], z[l]}; }
    Float8 square() const { return x * x + y * y + z * z; }
};

/// Walks the blocks of a leaf relative to a point: `hits4`, `hits2` say which lanes to go into,
/// `squares(lanes)` gives squared distances.
template <class Hits, class Squares>
VDBPACK_INLINE void walk(const Float3& middle, float* squares, const Hits& hits,
                         const Squares& squaresOf) {
    const Lanes blocks4(middle, 2);
    forEachSet(hits(blocks4, kHalf4, kRadius4), [&](std::size_t i) {
        const Lanes blocks2(blocks4.at(i), 1);
        forEachSet(hits(blocks2, kHalf2, kRadius2), [&](std::size_t j) {
            const Lanes voxels(blocks2.at(j), 0.5f);
            float* const to = squares + 64 * i + 8 * j;
            store(to, smaller(squaresOf(voxels), load(to)));
        });
    });
}

}  // namespace

void LeafDistances::start(const BandLeaf& leaf) {
    constexpr double kMiddle = 0.5 * (kLeafSide - 1);
    for (int i = 0; i < 3; ++i) center_[i] = leaf.origin[static_cast<std::size_t>(i)] + kMiddle;
    if (leaf.squares)
        std::transform(leaf.squares->begin(), leaf.squares->end(), squares_.begin(),
                       [](const auto& square) { return square.load(std::memory_order_relaxed); });
    else
        squares_.fill(std::numeric_limits<float>::infinity());
}

void LeafDistances::addTriangle(std::uint32_t triangle) {
    const Vec<3> a = mesh_.corner(triangle, 0) - center_, b = mesh_.corner(triangle, 1) - center_,
                 c = mesh_.corner(triangle, 2) - center_;
    const Vec<3> n = bandNormal(a, b, c);
    const BandWidths widths = mesh_.widths(triangle);
    const Linear plane(n, -dot(n, a));
    // Positive on the inner side of each edge; in voxels times the length of the edge.
    const auto sideOf = [&](const Vec<3>& from, const Vec<3>& to) {
        const Vec<3> inward = cross(n, to - from);
        return Linear(inward, -dot(inward, from));
    };
    const Linear ab = sideOf(a, b), bc = sideOf(b, c), ca = sideOf(c, a);
    constexpr auto kGap = static_cast<float>(kFlat);
    const auto hits = [&](Float8 d, Float8 s0, Float8 s1, Float8 s2, float half) {
        const float more = half * plane.support + kRounding;
        const float beside = half + kRounding + kGap * widths.larger();
        return (d <= widths.above + more) & (d >= -widths.below - more) &
               (s0 >= -beside * ab.support) & (s1 >= -beside * bc.support) &
               (s2 >= -beside * ca.support);
    };
    const Float8 d4 = plane.blocks4(), ab4 = ab.blocks4(), bc4 = bc.blocks4(), ca4 = ca.blocks4();
    forEachSet(hits(d4, ab4, bc4, ca4, kHalf4), [&](std::size_t i) {
        const Float8 d2 = plane.blocks2(d4[i]), ab2 = ab.blocks2(ab4[i]), bc2 = bc.blocks2(bc4[i]),
                     ca2 = ca.blocks2(ca4[i]);
        forEachSet(hits(d2, ab2, bc2, ca2, kHalf2), [&](std::size_t j) {
            const Float8 d = plane.voxels(d2[j]);
            const Float8 beside = absolute(d) * -kGap - kRounding;
            const Int8 inside = (ab.voxels(ab2[j]) >= beside * ab.support) &
                                (bc.voxels(bc2[j]) >= beside * bc.support) &
                                (ca.voxels(ca2[j]) >= beside * ca.support);
            float* const to = squares_.data() + 64 * i + 8 * j;
            const Float8 before = load(to);
            store(to, choose(inside, smaller(d * d, before), before));
        });
    });
}

void LeafDistances::addEdge(const BandEdge& edge) {
    const Vec<3> a = mesh_.vertices[edge.a] - center_, b = mesh_.vertices[edge.b] - center_;
    const double l = length(b - a);
    const Vec<3> along = l > 0 ? (b - a) * (1 / l) : Vec<3>{{1, 0, 0}};
    // The nearest point of the line to the center: parameters count from there, so that those of a
    // long edge are exact where they matter.
    const Vec<3> foot = a - along * dot(a, along);
    const auto t0 = static_cast<float>(dot(a, along)), t1 = static_cast<float>(dot(b, along));
    const Float3 e = single(along);
    const float support = std::fabs(e.x) + std::fabs(e.y) + std::fabs(e.z);
    const float farthest = edge.reach + kSlack;
    const Float3 u0 = single(edge.inward0(along)), u1 = single(edge.inward1(along));
    const auto product = [](const Float3& u, const Lanes& w) {
        return w.x * u.x + w.y * u.y + w.z * u.z;
    };
    const auto supportOf = [](const Float3& u) {
        return std::fabs(u.x) + std::fabs(u.y) + std::fabs(u.z);
    };
    const float s0 = supportOf(u0), s1 = supportOf(u1);
    const auto hits = [&](const Lanes& w, float half, float radius) {
        const Float8 t = product(e, w);
        const float most = (farthest + radius) * (farthest + radius);
        return (t >= t0 - half * support - kRounding) & (t <= t1 + half * support + kRounding) &
               (product(u0, w) >= -half * s0 - kRounding) &
               (product(u1, w) >= -half * s1 - kRounding) & (w.square() - t * t <= most);
    };
    const auto squares = [&](const Lanes& w) {
        const Float8 t = smaller(larger(product(e, w), t0), everyLane(t1));
        const Float8 x = w.x - t * e.x, y = w.y - t * e.y, z = w.z - t * e.z;
        return x * x + y * y + z * z;
    };
    walk(single(foot * -1.0), squares_.data(), hits, squares);
}

void LeafDistances::addVertex(const BandVertex& vertex) {
    const Float3 middle = single((mesh_.vertices[vertex.vertex] - center_) * -1.0);
    const float ax = vertex.axis[0], ay = vertex.axis[1], az = vertex.axis[2];
    const float cosine = vertex.cosine, farthest = vertex.reach + kSlack;
    const auto hits = [&](const Lanes& w, float, float radius) {
        const Float8 square = w.square();
        const float most = (farthest + radius) * (farthest + radius);
        Int8 hit = square <= most;
        if (cosine > 0)
            hit = hit & (w.x * ax + w.y * ay + w.z * az + (radius * (1 + cosine) + kRounding) >=
                         squareRoot(square) * cosine);
        return hit;
    };
    walk(middle, squares_.data(), hits, [](const Lanes& w) { return w.square(); });
}

}  // namespace vdbpack
