#include "support/generators.h"
#include "support/test.h"
#include "support/triangle_oracle.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/facet_bins.h"

#include <tbb/global_control.h>

namespace {

double distanceTo(const Facet<3>& f, const Vec<3>& x) {
    return test::distanceTo(x, f[0], f[1], f[2]);
}

double distanceTo(const Facet<2>& f, const Vec<2>& x) {
    const auto lifted = [](const Vec<2>& v) { return Vec<3>{{v[0], v[1], 0}}; };
    return test::distanceTo(lifted(x), lifted(f[0]), lifted(f[1]), lifted(f[1]));
}

std::vector<Facet<3>> facetsOf(const TriangleMesh& mesh) {
    std::vector<Facet<3>> facets;
    for (const auto& t : mesh.triangles)
        facets.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    return facets;
}

template <int Dim>
double bruteForce(const std::vector<Facet<Dim>>& facets, const Vec<Dim>& x) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& facet : facets) best = std::min(best, distanceTo(facet, x));
    return best;
}

template <int Dim>
Vec<Dim> randomVec(RandomStream& random, double size) {
    Vec<Dim> x;
    for (int i = 0; i < Dim; ++i) x[i] = size * (random.uniform() - 0.5);
    return x;
}

/// Facets of sizes from 0.01 to 50 in a box of 20, some without area, moved by `far`.
template <int Dim>
std::vector<Facet<Dim>> mixedFacets(std::uint64_t seed, int count, double far) {
    RandomStream random(seed, 1);
    Vec<Dim> shift;
    for (int i = 0; i < Dim; ++i) shift[i] = far * (i + 1);
    std::vector<Facet<Dim>> facets;
    for (int k = 0; k < count; ++k) {
        const Vec<Dim> center = randomVec<Dim>(random, 20) + shift;
        const double size = std::pow(10.0, -2 + 2.5 * random.uniform()) * (k % 97 == 0 ? 20 : 1);
        Facet<Dim> facet;
        for (auto& corner : facet) corner = center + randomVec<Dim>(random, size);
        if (k % 31 == 0) facet[0] = facet[1];
        if (k % 37 == 0) facet.back() = facet[0] + (facet[1] - facet[0]) * 0.3;
        facets.push_back(facet);
    }
    return facets;
}

template <int Dim>
void requireLikeBruteForce(const FacetBins<Dim>& bins, const std::vector<Facet<Dim>>& facets,
                           const Vec<Dim>& x, double tolerance) {
    const double expected = bruteForce(facets, x);
    WallPoint<Dim> wall;
    REQUIRE(bins.nearest(x, expected + 1, wall));
    REQUIRE(std::abs(wall.distance - expected) < tolerance);
    REQUIRE(std::abs(length(wall.point - x) - wall.distance) < tolerance);
    REQUIRE(bins.anyCloser(x, expected + 2 * tolerance));
    if (expected > 2 * tolerance) {
        REQUIRE_FALSE(bins.anyCloser(x, expected - 2 * tolerance));
        const WallPoint<Dim> before = wall;
        REQUIRE_FALSE(bins.nearest(x, expected - 2 * tolerance, wall));
        REQUIRE(wall.point == before.point);
    }
}

}  // namespace

DIM_TEST_CASE("bins find the same nearest facet as a search through all") {
    const auto seed = GENERATE(range(1u, 6u));
    const double far = GENERATE(0.0, 1e4);
    CAPTURE(Dim, seed, far);
    const auto facets = mixedFacets<Dim>(seed, 700, far);
    const FacetBins<Dim> bins(facets);
    RandomStream random(seed, 2);
    const double tolerance = far > 0 ? 1e-8 : 1e-10;
    for (int k = 0; k < 300; ++k) {
        // Within, around and far outside; then corners, edges and just beside them.
        Vec<Dim> x = bins.bounds().center() + randomVec<Dim>(random, k % 3 == 0 ? 300 : 25);
        const auto& facet = facets[static_cast<std::size_t>(k)];
        if (k % 3 == 1) x = facet[0];
        if (k % 6 == 2) x = (facet[0] + facet[1]) * 0.5 + randomVec<Dim>(random, 1e-3);
        requireLikeBruteForce(bins, facets, x, tolerance);
    }
}

DIM_TEST_CASE("bins find every facet within reach, and no other") {
    const auto seed = GENERATE(range(1u, 4u));
    const double reach = GENERATE(0.1, 1.0, 6.0);
    CAPTURE(Dim, seed, reach);
    const auto facets = mixedFacets<Dim>(seed, 400, 0);
    const FacetBins<Dim> bins(facets);
    RandomStream random(seed, 3);
    for (int k = 0; k < 100; ++k) {
        const Vec<Dim> x = bins.bounds().center() + randomVec<Dim>(random, 25);
        std::vector<double> expected;
        for (const auto& facet : facets)
            if (const double d = distanceTo(facet, x); d < reach) expected.push_back(d);
        std::vector<WallPoint<Dim>> points;
        bins.within(x, reach, points);
        std::vector<double> found;
        for (const auto& p : points) {
            REQUIRE(std::abs(length(p.point - x) - p.distance) < 1e-9);
            found.push_back(p.distance);
        }
        // Some may come more than once: compare without repeats.
        for (auto* distances : {&expected, &found}) {
            std::sort(distances->begin(), distances->end());
            distances->erase(std::unique(distances->begin(), distances->end(),
                                         [](double a, double b) { return b - a < 1e-8; }),
                             distances->end());
        }
        REQUIRE(found.size() == expected.size());
        for (std::size_t i = 0; i < found.size(); ++i)
            REQUIRE(found[i] == Approx(expected[i]).margin(1e-7));
    }
}

TEST_CASE("bins answer exactly all over a mesh, also beside edges and vertices") {
    const auto facets = facetsOf(ballMesh(10, 4));
    const FacetBins<3> bins(facets);
    RandomStream random(3, 3);
    for (int k = 0; k < 150; ++k) {
        const auto& t =
            facets[static_cast<std::size_t>(random.uniform() * static_cast<double>(facets.size()))];
        const double height = 1 + 0.4 * (random.uniform() - 0.5);
        const Vec<3> x = k % 3 == 0   ? t[0] * height
                         : k % 3 == 1 ? (t[0] + t[1]) * (0.5 * height)
                                      : (t[0] + t[1] + t[2]) * (height / 3);
        requireLikeBruteForce(bins, facets, x, 1e-12);
    }
    requireLikeBruteForce(bins, facets, Vec<3>{}, 1e-12);
    requireLikeBruteForce(bins, facets, Vec<3>{{1e6, 0, 0}}, 1e-8);
}

TEST_CASE("a fan of thousands of long triangles is searched exactly, in memory as for others") {
    const auto facets = facetsOf(rotated(doubleConeMesh(10, 8, 20000), {{1, 2, 3}}, 0.7));
    const FacetBins<3> bins(facets);
    REQUIRE(bins.memoryBytes() < 256 * facets.size());
    RandomStream random(3, 5);
    for (int k = 0; k < 60; ++k) {
        // Anywhere, beside a triangle, near the tips.
        Vec<3> x = randomVec<3>(random, 30);
        const auto& facet = facets[static_cast<std::size_t>(k) * 311];
        if (k % 3 == 1) x = (facet[0] + facet[1] + facet[2]) * (1.0 / 3) + randomVec<3>(random, 1);
        if (k % 3 == 2) x = facet[2] + randomVec<3>(random, 0.1);
        requireLikeBruteForce(bins, facets, x, 1e-12);
        const double reach = bruteForce(facets, x) + 1e-4;
        std::vector<WallPoint<3>> points;
        bins.within(x, reach, points);
        const auto expected = std::count_if(
            facets.begin(), facets.end(), [&](const auto& f) { return distanceTo(f, x) < reach; });
        REQUIRE(static_cast<std::ptrdiff_t>(points.size()) == expected);
    }
}

TEST_CASE("a huge triangle among tiny ones neither hides them nor fills memory") {
    auto facets = mixedFacets<3>(9, 500, 0);
    for (auto& facet : facets)
        for (auto& corner : facet) corner = corner * 1e-3;
    facets.push_back({Vec<3>{{-4e4, -5e4, -1}}, Vec<3>{{6e4, -1e4, 2}}, Vec<3>{{3e3, 7e4, -3}}});
    facets.push_back({Vec<3>{{0, 0, -1e5}}, Vec<3>{{0, 0, 1e5}}, Vec<3>{{1e-12, 0, 3}}});
    const FacetBins<3> bins(facets);
    REQUIRE(bins.memoryBytes() < 8u << 20);
    RandomStream random(4, 4);
    for (int k = 0; k < 200; ++k)
        requireLikeBruteForce(bins, facets, randomVec<3>(random, k % 2 == 0 ? 0.04 : 1e5), 1e-7);
}

TEST_CASE("bins of nothing, of a point and of a flat square") {
    WallPoint<3> wall;
    REQUIRE_FALSE(FacetBins<3>({}).nearest({}, 1e9, wall));
    REQUIRE_FALSE(FacetBins<3>({}).anyCloser({}, 1e9));
    const Vec<3> p{{1, 2, 3}};
    const FacetBins<3> point({{p, p, p}});
    REQUIRE(point.nearest({{1, 2, 5}}, 2.1, wall));
    REQUIRE(wall.distance == 2);
    REQUIRE_FALSE(point.nearest({{1, 2, 5}}, 2, wall));
    REQUIRE_FALSE(point.nearest({{1, 2, 5}}, -1, wall));
    REQUIRE_FALSE(point.nearest({{1, 2, 5}}, std::nan(""), wall));
    const FacetBins<3> square({{Vec<3>{{0, 0, 0}}, Vec<3>{{1, 0, 0}}, Vec<3>{{1, 1, 0}}},
                               {Vec<3>{{0, 0, 0}}, Vec<3>{{1, 1, 0}}, Vec<3>{{0, 1, 0}}}});
    REQUIRE(square.nearest({{0.4, 0.6, -0.25}}, 1, wall));
    REQUIRE(wall.distance == Approx(0.25).epsilon(1e-14));
    REQUIRE(square.nearest({{2, 2, 1}}, 3, wall));
    REQUIRE(wall.point == Vec<3>{{1, 1, 0}});
}

TEST_CASE("bins do not depend on the number of threads") {
    const auto facets = mixedFacets<3>(2, 20000, 0);
    const auto build = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return FacetBins<3>(facets);
    };
    const auto one = build(1), many = build(8);
    RandomStream random(6, 6);
    for (int k = 0; k < 500; ++k) {
        const Vec<3> x = randomVec<3>(random, 22);
        WallPoint<3> a, b;
        REQUIRE(one.nearest(x, 5, a) == many.nearest(x, 5, b));
        REQUIRE(a.point == b.point);
        REQUIRE(a.distance == b.distance);
    }
}
