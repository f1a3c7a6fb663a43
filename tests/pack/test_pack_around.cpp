// Gaps, spheres that stand already, other orders and mixtures of very different sizes.
#include "support/cube.h"
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/pack/front/cell_list.h"
#include "vdbpack/pack/packer.h"

namespace {

/// The smallest gap between a sphere of `a` and another one of `b`.
template <int Dim>
double smallestGap(const std::vector<Sphere<Dim>>& a, const std::vector<Sphere<Dim>>& b) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j)
            if (&a != &b || i != j) least = std::min(least, gap(a[i], b[j]));
    return least;
}

template <int Dim>
double smallestWallGap(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    const auto sampler = domain.sampler();
    double least = std::numeric_limits<double>::infinity();
    for (const auto& s : spheres)
        least = std::min(least, -sampler->signedDistance(s.center) - s.radius);
    return least;
}

}  // namespace

TEST_CASE("nothing is placed beside existing spheres where nothing can fit") {
    PackOptions options(SizeDistribution::parse("constant:11", 3));
    const auto domain = boxDomain<3>(cube<3>(20));
    const auto result = packSpheres(*domain, options, {}, {{{{0, 0, 0}}, 1}});
    CHECK(result.pack.spheres.empty());
    CHECK(result.quantum > 0);
    CHECK_THROWS_WITH(packSpheres(*domain, options), Contains("fits"));
}

TEST_CASE("packing around a heap of spheres stops before its first sphere if asked to") {
    std::vector<Sphere<3>> heap;
    for (int i = 0; i < 1000; ++i)
        heap.push_back({{{0.6 * (i % 10) - 3, 0.6 * (i / 10 % 10) - 3, 0.6 * (i / 100) - 3}}, 1});
    PackOptions options(SizeDistribution::parse("constant:1", 3));
    options.threads = 1;
    int asked = 0;
    Callbacks callbacks;
    callbacks.cancelled = [&] { return ++asked > 5; };
    const auto result = packSpheres(*boxDomain<3>(cube<3>(20)), options, callbacks, heap);
    CHECK(result.interrupted);
    CHECK(result.pack.spheres.empty());
    CHECK(asked < 20);
}

DIM_TEST_CASE("a gap is kept between spheres and to the wall") {
    const double wanted = GENERATE(0.05, 0.4, 2.0);
    const bool round = GENERATE(false, true);
    CAPTURE(Dim, wanted, round);
    const double size = Dim == 3 ? 36 : 90;
    const auto domain = round ? ballDomain<Dim>(size / 2) : boxDomain<Dim>(cube<Dim>(size));
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.gap = wanted;
    options.blockSide = 16;
    const auto result = packSpheres(*domain, options);
    REQUIRE(result.pack.spheres.size() > 50);
    const double between = smallestGap(result.pack.spheres, result.pack.spheres);
    CHECK(between >= wanted * (1 - 1e-12));
    CHECK(between < wanted + 1e-5);
    const double wall = smallestWallGap(result.pack.spheres, *domain);
    CHECK(wall >= wanted * (1 - 1e-12));
    CHECK(wall < wanted + 1e-5);
    std::set<double> drawn;
    for (const auto& s : result.pack.spheres) {
        CHECK(static_cast<double>(static_cast<float>(s.radius)) == s.radius);
        drawn.insert(s.radius);
    }
    CHECK(*drawn.begin() >= 1);
    CHECK(*drawn.rbegin() <= 2);
    // Spheres grown by half the gap, in a domain that is as much smaller, are packed as ever.
    std::vector<Sphere<Dim>> grown = result.pack.spheres;
    for (auto& s : grown) s.radius += wanted / 2;
    CHECK(solidFraction(grown, *domain) > (Dim == 3 ? 0.38 : 0.65));
}

TEST_CASE("a gap that makes no sense is refused, and one that leaves no room says so") {
    const auto domain = boxDomain<3>(cube<3>(10));
    PackOptions options(SizeDistribution::parse("uniform:1,2", 3));
    for (const double gap : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        options.gap = gap;
        CHECK_THROWS_AS(packSpheres(*domain, options), ParameterError);
    }
    options.gap = 4.5;
    CHECK_THROWS_WITH(packSpheres(*domain, options), Contains("0.5 mm") && Contains("(0, 0, 0)"));
    options.gap = 50;
    CHECK_THROWS_AS(packSpheres(*domain, options), InputError);
}

DIM_TEST_CASE("an inset domain is the shape with a smaller size") {
    // A box and a ball moved inwards are a box and a ball.
    constexpr double kInset = 1.5;
    const std::pair<std::shared_ptr<const Domain<Dim>>, std::shared_ptr<const Domain<Dim>>>
        pairs[] = {{boxDomain<Dim>(cube<Dim>(20)), boxDomain<Dim>(cube<Dim>(17))},
                   {ballDomain<Dim>(10), ballDomain<Dim>(8.5)}};
    RandomStream random(3, Dim);
    for (const auto& [outer, expected] : pairs) {
        const auto inset = insetDomain(*outer, kInset);
        for (int d = 0; d < Dim; ++d) CHECK(inset->bounds().lo[d] == expected->bounds().lo[d]);
        const auto mine = inset->sampler(), oracle = expected->sampler();
        for (int k = 0; k < 2000; ++k) {
            const Vec<Dim> x = randomPoint(random, cube<Dim>(24));
            const double depth = -oracle->signedDistance(x);
            CHECK(mine->contains(x) == (depth > 0));
            if (depth < 0) continue;  // outside only the sign counts
            WallPoint<Dim> wall;
            CHECK_FALSE(mine->nearestWall(x, depth * (1 - 1e-12), wall));
            REQUIRE(mine->nearestWall(x, depth + 1e-9, wall));
            CHECK(wall.distance == Approx(depth).margin(1e-12));
            CHECK(length(wall.point - x) == Approx(depth).margin(1e-9));
            CHECK(oracle->signedDistance(wall.point) == Approx(0).margin(1e-9));
        }
    }
}

DIM_TEST_CASE("spheres that stand already are kept off, whatever their size") {
    const double gap = GENERATE(0.0, 0.3);
    CAPTURE(Dim, gap);
    const double side = Dim == 3 ? 60 : 150;
    const auto domain = boxDomain<Dim>(cube<Dim>(side));
    // Small ones, one like the new ones, a large one through the wall, two that overlap, one that
    // reaches in from far outside, and one that has nothing to do with it.
    std::vector<Sphere<Dim>> existing;
    const auto at = [](double x, double y) {
        Vec<Dim> v{};
        v[0] = x, v[1] = y;
        return v;
    };
    existing.push_back({at(5, 5), 0.2});
    existing.push_back({at(-5, 5), 1.5});
    existing.push_back({at(-side / 2, 0), 12});
    existing.push_back({at(12, -8), 6});
    existing.push_back({at(16, -8), 5});
    existing.push_back({at(0, side / 2 + 300), 305});
    existing.push_back({at(0, -900), 10});
    // Nothing may rest on one outside, or reach the outside over one in the wall.
    existing.push_back({at(side / 2 + 4, 9), 1.5});
    existing.push_back({at(side / 2 + 0.5, -9), 1.5});
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.gap = gap;
    options.blockSide = 16;
    options.threads = 1;
    const auto one = packSpheres(*domain, options, {}, existing);
    CHECK(smallestGap(one.pack.spheres, one.pack.spheres) >= gap * (1 - 1e-12));
    const double off = smallestGap(one.pack.spheres, existing);
    CHECK(off >= gap * (1 - 1e-12));
    CHECK(off < gap + 1e-5);
    CHECK(smallestWallGap(one.pack.spheres, *domain) >= gap * (1 - 1e-12));
    options.threads = 8;
    CHECK(packSpheres(*domain, options, {}, existing).pack.spheres == one.pack.spheres);
    // What is left of the domain is as full as ever: volume free by counting points.
    RandomStream random(5, 0);
    int free = 0;
    constexpr int kPoints = 20000;
    for (int k = 0; k < kPoints; ++k) {
        const Vec<Dim> x = randomPoint(random, cube<Dim>(side));
        free += std::all_of(existing.begin(), existing.end(),
                            [&](const Sphere<Dim>& s) { return length(x - s.center) > s.radius; });
    }
    if (gap == 0)
        CHECK(solidFraction(one.pack.spheres, *domain) * kPoints / free > (Dim == 3 ? 0.59 : 0.78));
}

TEST_CASE("a full pack takes no more spheres of its kind") {
    const auto domain = boxDomain<3>(cube<3>(40));
    PackOptions options(SizeDistribution::parse("uniform:1,2", 3));
    const auto first = packSpheres(*domain, options);
    options.seed = 2;
    const auto second = packSpheres(*domain, options, {}, first.pack.spheres);
    CHECK(second.pack.spheres.size() < first.pack.spheres.size() / 20);
    CHECK(smallestGap(second.pack.spheres, first.pack.spheres) >= 0);
    // A sixth of the volume of a sphere fits between them.
    PackOptions fine(SizeDistribution::parse("uniform:0.2,0.4", 3));
    const auto third = packSpheres(*domain, fine, {}, first.pack.spheres);
    CHECK(third.pack.spheres.size() > first.pack.spheres.size());
    CHECK(smallestGap(third.pack.spheres, first.pack.spheres) >= 0);
}

DIM_TEST_CASE("every order gives a sound pack") {
    const Order order =
        GENERATE(Order::sweep, Order::waves, Order::wall, Order::center, Order::fifo);
    CAPTURE(Dim, static_cast<int>(order));
    const auto domain = boxDomain<Dim>(cube<Dim>(Dim == 3 ? 40 : 120));
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.order = order;
    options.threads = 2;
    const auto result = packSpheres(*domain, options);
    const auto& spheres = result.pack.spheres;
    CHECK(smallestGap(spheres, spheres) >= 0);
    CHECK(smallestWallGap(spheres, *domain) >= 0);
    CHECK(solidFraction(spheres, *domain) > (Dim == 3 ? 0.52 : 0.75));
    if (!sweeps(order)) CHECK(result.blocks == 1);
    // Depth of the first tenth against all: wall first is shallow, from the middle deep.
    const auto sampler = domain->sampler();
    const auto meanDepth = [&](std::size_t count) {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum -= sampler->signedDistance(spheres[i].center);
        return sum / static_cast<double>(count);
    };
    const double first = meanDepth(spheres.size() / 10), all = meanDepth(spheres.size());
    if (order == Order::wall) CHECK(first < 0.5 * all);
    if (order == Order::center || order == Order::fifo) CHECK(first > 1.5 * all);
}

TEST_CASE("few large spheres among many small ones") {
    // 9 % of radius 3 to 10 among radii of 1 to 2: neighbors are sought for the common ones alone.
    std::vector<double> radii, weights;
    for (int i = 0; i < 20; ++i) {
        radii.insert(radii.end(), {1 + i / 20.0, 3 + 7 * i / 20.0});
        weights.insert(weights.end(), {0.0475, 0.0025});
    }
    PackOptions options(SizeDistribution::table(radii, weights));
    const auto domain = boxDomain<3>(cube<3>(90));
    options.threads = 1;
    const auto result = packSpheres(*domain, options);
    const auto& spheres = result.pack.spheres;
    CHECK(smallestGap(spheres, spheres) >= 0);
    CHECK(smallestWallGap(spheres, *domain) >= 0);
    CHECK(solidFraction(spheres, *domain) > 0.64);
    const auto large = std::count_if(spheres.begin(), spheres.end(),
                                     [](const Sphere<3>& s) { return s.radius >= 3; });
    CHECK(static_cast<double>(large) > 0.02 * static_cast<double>(spheres.size()));
    options.threads = 8;
    CHECK(packSpheres(*domain, options).pack.spheres == spheres);
}

DIM_TEST_CASE("a cell list finds the spheres in reach among sizes of all kinds") {
    RandomStream random(9, Dim);
    CellList<Dim> cells;
    for (int round = 0; round < 5; ++round) {
        cells.reset({Box<Dim>::filled(0), Box<Dim>::filled(40)}, 3, 1);
        std::vector<Sphere<Dim>> spheres;
        for (std::uint32_t i = 0; i < 400; ++i) {
            Sphere<Dim> s;
            for (int d = 0; d < Dim; ++d) s.center[d] = 60 * random.uniform() - 10;
            s.radius = 0.1 * std::pow(300.0, random.uniform());  // to 30
            cells.add(s, i);
            spheres.push_back(s);
        }
        for (int k = 0; k < 200; ++k) {
            const Vec<Dim> x =
                randomPoint(random, Box<Dim>{Box<Dim>::filled(-2), Box<Dim>::filled(42)});
            const double reach = 5 * random.uniform();
            std::set<std::uint32_t> found;
            cells.near(x, reach, [&](std::uint32_t i) {
                CHECK(found.insert(i).second);
                return true;
            });
            for (std::uint32_t i = 0; i < spheres.size(); ++i) {
                const double open = length(spheres[i].center - x) - spheres[i].radius;
                if (open < reach) CHECK(found.count(i) == 1);
                if (open > reach + 0.01) CHECK(found.count(i) == 0);
            }
        }
    }
}
