#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"

namespace {

template <int Dim>
Box<Dim> sampleBox() {
    Box<Dim> box;
    for (int i = 0; i < Dim; ++i) {
        box.lo[i] = -2.0 - i;
        box.hi[i] = 3.0 + 2 * i;
    }
    return box;
}

template <int Dim>
std::vector<std::shared_ptr<const Domain<Dim>>> shapes() {
    std::vector<std::shared_ptr<const Domain<Dim>>> all;
    Vec<Dim> center;
    for (int i = 0; i < Dim; ++i) center[i] = 100.0 * (i + 1);
    all.push_back(boxDomain<Dim>(sampleBox<Dim>()));
    all.push_back(ballDomain<Dim>(2.5));
    all.push_back(ballDomain<Dim>(2.5, center));
    if constexpr (Dim == 3) {
        all.push_back(cylinderDomain(2, 7));
        all.push_back(cylinderDomain(4, 1));
    }
    return all;
}

/// Shape cut by three planes, none of them along an axis.
template <int Dim>
std::shared_ptr<const Domain<Dim>> threeCuts(const std::shared_ptr<const Domain<Dim>>& shape) {
    const Vec<Dim> center = shape->bounds().center();
    std::vector<HalfSpace<Dim>> planes(3);
    const double normals[3][3] = {{1, 0.5, -0.3}, {-0.2, -1, 0.4}, {0.3, -0.4, 2}};
    for (int k = 0; k < 3; ++k) {
        auto& plane = planes[static_cast<std::size_t>(k)];
        for (int i = 0; i < Dim; ++i) plane.normal[i] = normals[k][i];
        plane.offset = dot(plane.normal, center) + 0.4 * length(plane.normal) * (k + 1) / 2;
    }
    return clippedDomain<Dim>(shape, planes);
}

template <int Dim>
double monteCarloDeeperThan(const Domain<Dim>& domain, double depth, int points) {
    RandomStream random(5, 1);
    const auto asker = domain.sampler();
    int inside = 0;
    for (int i = 0; i < points; ++i)
        if (asker->signedDistance(randomPoint(random, domain.bounds())) < -depth) ++inside;
    return domain.bounds().volume() * inside / points;
}

}  // namespace

DIM_TEST_CASE("the nearest wall point of a shape lies on its wall, as far away as said") {
    for (const auto& shape : shapes<Dim>()) {
        CAPTURE(Dim, shape->facts().kind);
        RandomStream random(1, 2);
        const auto asker = shape->sampler();
        for (int i = 0; i < 2000; ++i) {
            const auto x = randomPoint(random, shape->bounds().grown(3));
            const double distance = asker->signedDistance(x);
            WallPoint<Dim> wall;
            REQUIRE(asker->nearestWall(x, 1e9, wall));
            REQUIRE(wall.distance == Approx(std::abs(distance)).margin(1e-12));
            REQUIRE(length(wall.point - x) == Approx(wall.distance).margin(1e-11));
            REQUIRE(std::abs(asker->signedDistance(wall.point)) < 1e-11);
            REQUIRE_FALSE(asker->nearestWall(x, wall.distance * (1 - 1e-9) - 1e-9, wall));
            REQUIRE((distance > 0 || shape->bounds().contains(x)));
        }
    }
}

DIM_TEST_CASE("inside a clipped shape distances are exact") {
    for (const auto& shape : shapes<Dim>()) {
        CAPTURE(Dim, shape->facts().kind);
        const auto clipped = threeCuts<Dim>(shape);
        RandomStream random(3, 4);
        const auto asker = clipped->sampler();
        int inside = 0;
        for (int i = 0; i < 2000; ++i) {
            const auto x = randomPoint(random, clipped->bounds());
            const double distance = asker->signedDistance(x);
            if (distance >= 0) continue;
            ++inside;
            WallPoint<Dim> wall;
            REQUIRE(asker->nearestWall(x, 1e9, wall));
            REQUIRE(wall.distance == Approx(-distance).margin(1e-12));
            // On the wall, and nothing outside is nearer.
            REQUIRE(std::abs(asker->signedDistance(wall.point)) < 1e-11);
            for (int k = 0; k < 50; ++k) {
                Vec<Dim> direction;
                for (int d = 0; d < Dim; ++d) direction[d] = random.uniform() - 0.5;
                const auto y = x + normalized(direction) * (wall.distance * 0.999999);
                REQUIRE(asker->signedDistance(y) < 0);
            }
        }
        REQUIRE(inside > 100);
    }
}

DIM_TEST_CASE("measures agree with random points") {
    const int points = 200000;
    for (const auto& shape : shapes<Dim>())
        for (const bool cut : {false, true}) {
            const auto domain = cut ? threeCuts<Dim>(shape) : shape;
            CAPTURE(Dim, shape->facts().kind, cut);
            for (const double depth : {0.0, 0.1, 0.3}) {
                const double expected = monteCarloDeeperThan(*domain, depth, points);
                const double whole = domain->bounds().volume();
                const double sigma = whole / (2 * std::sqrt(points));
                REQUIRE(std::abs(domain->volumeDeeperThan(depth) - expected) < 5 * sigma);
            }
            REQUIRE(domain->volumeDeeperThan(0) == Approx(domain->volume()).epsilon(1e-12));
            REQUIRE(domain->volumeDeeperThan(100) == 0);
        }
}

TEST_CASE("plain shapes have textbook measures") {
    REQUIRE(ballDomain<3>(3)->volume() == Approx(36 * kPi));
    REQUIRE(ballDomain<3>(3)->wallArea() == Approx(36 * kPi));
    REQUIRE(ballDomain<2>(3)->volume() == Approx(9 * kPi));
    REQUIRE(ballDomain<2>(3)->wallArea() == Approx(6 * kPi));
    REQUIRE(cylinderDomain(2, 5)->volume() == Approx(20 * kPi));
    REQUIRE(cylinderDomain(2, 5)->wallArea() == Approx(28 * kPi));
    REQUIRE(cylinderDomain(2, 5)->volumeDeeperThan(1) == Approx(3 * kPi));
    REQUIRE(boxDomain<3>({{{0, 0, 0}}, {{1, 2, 3}}})->wallArea() == Approx(22));
    REQUIRE(boxDomain<3>({{{0, 0, 0}}, {{10, 12, 14}}})->volumeDeeperThan(2) == Approx(480));
    REQUIRE(boxDomain<2>({{{0, 0}}, {{4, 2}}})->wallArea() == Approx(12));
    REQUIRE(boxDomain<2>({{{0, 0}}, {{4, 2}}})->volumeDeeperThan(1) == 0);
}

TEST_CASE("a cut ball has the volume of a spherical cap within 0.05 %") {
    const double height = GENERATE(0.5, 3.0, 10.0, 17.0, 20.0);
    const Vec<3> direction = GENERATE(Vec<3>{{0, 0, 1}}, Vec<3>{{1, 0, 0}}, Vec<3>{{1, 2, -3}});
    const double radius = 10;
    CAPTURE(height);
    const Vec<3> center{{730, -100, 40}};
    const auto cap =
        clippedDomain<3>(ballDomain<3>(radius, center),
                         {{direction * -2.0,
                           -2 * (dot(direction, center) + length(direction) * (radius - height))}});
    const double expected = kPi * height * height * (radius - height / 3);
    REQUIRE(cap->volume() == Approx(expected).epsilon(5e-4));
    const double disc = kPi * height * (2 * radius - height);
    if (height < 20)
        REQUIRE(cap->wallArea() == Approx(2 * kPi * radius * height + disc).epsilon(5e-3));
    REQUIRE(cap->bounds().volume() > expected);
    const double out = 3 * std::pow(2 * radius - height, 2) / (4 * (3 * radius - height));
    REQUIRE(length(*cap->centroid() - center - normalized(direction) * out) < 2e-3);
}

TEST_CASE("a box cut along its axes is a box") {
    const auto box = boxDomain<3>({{{0, 0, 0}}, {{4, 5, 6}}});
    const auto cut = clippedDomain<3>(box, {{{{0, 0, 2}}, 4}, {{{-3, 0, 0}}, -3}});
    REQUIRE(cut->volume() == Approx(3 * 5 * 2));
    REQUIRE(cut->bounds().lo == Vec<3>{{1, 0, 0}});
    REQUIRE(cut->bounds().hi == Vec<3>{{4, 5, 2}});
    REQUIRE(cut->facts().kind == "box");
    REQUIRE(*cut->centroid() == Vec<3>{{2.5, 2.5, 1}});
}

TEST_CASE("cutting twice equals cutting once with both planes") {
    const HalfSpace<3> first{{{1, 1, 0}}, 1};
    const HalfSpace<3> second{{{0, -1, 1}}, 0.5};
    const auto ball = ballDomain<3>(3);
    const auto once = clippedDomain<3>(ball, {first, second});
    const auto twice = clippedDomain<3>(clippedDomain<3>(ball, {first}), {second});
    REQUIRE(twice->volume() == Approx(once->volume()).epsilon(1e-6));
    const auto a = once->sampler(), b = twice->sampler();
    RandomStream random(7, 7);
    for (int i = 0; i < 100; ++i) {
        const auto x = randomPoint(random, ball->bounds());
        REQUIRE(a->signedDistance(x) == b->signedDistance(x));
    }
}

TEST_CASE("slices of shapes are shapes") {
    REQUIRE(sliceDomain(ballDomain<3>(5, {{1, 2, 3}}), 6)->volume() == Approx(16 * kPi));
    REQUIRE(sliceDomain(ballDomain<3>(5, {{1, 2, 3}}), 6)->facts().kind == "slice");
    REQUIRE(sliceDomain(cylinderDomain(2, 5), 1)->volume() == Approx(4 * kPi));
    REQUIRE(sliceDomain(boxDomain<3>({{{0, 0, 0}}, {{2, 3, 4}}}), 1)->volume() == Approx(6));
    const auto half = clippedDomain<3>(ballDomain<3>(5), {{{{1, 0, 1}}, 3}});
    REQUIRE(sliceDomain(half, 3)->volume() == Approx(8 * kPi).epsilon(1e-6));
    REQUIRE_THROWS_AS(sliceDomain(half, 4.9), InputError);
    REQUIRE_THROWS_AS(sliceDomain(ballDomain<3>(5), 5), InputError);
    REQUIRE_THROWS_AS(sliceDomain(boxDomain<3>({{{0, 0, 0}}, {{2, 3, 4}}}), -1), InputError);
    REQUIRE_THROWS_AS(sliceDomain(ballDomain<3>(5), std::nan("")), ParameterError);
}

TEST_CASE("unusable shapes are refused") {
    REQUIRE_THROWS_AS(ballDomain<3>(0), ParameterError);
    REQUIRE_THROWS_AS(ballDomain<2>(-1), ParameterError);
    REQUIRE_THROWS_AS(ballDomain<3>(std::nan("")), ParameterError);
    REQUIRE_THROWS_AS(ballDomain<3>(1, {{0, INFINITY, 0}}), ParameterError);
    REQUIRE_THROWS_AS(cylinderDomain(1, 0), ParameterError);
    REQUIRE_THROWS_AS(cylinderDomain(INFINITY, 1), ParameterError);
    for (const double length : {1e-200, 1e200}) {
        // Numbers, but their volumes are 0 or none.
        const Box<3> cube{{}, {{length, length, length}}};
        const Box<2> square{{}, {{length, length}}};
        REQUIRE_THROWS_AS(ballDomain<3>(length), ParameterError);
        REQUIRE_THROWS_AS(ballDomain<2>(length), ParameterError);
        REQUIRE_THROWS_AS(cylinderDomain(length, length), ParameterError);
        REQUIRE_THROWS_AS(boxDomain<3>(cube), ParameterError);
        REQUIRE_THROWS_AS(boxDomain<2>(square), ParameterError);
        REQUIRE_THROWS_AS(periodicDomain<3>({cube, {true, true, true}}), ParameterError);
    }
    REQUIRE_THROWS_AS(boxDomain<2>({{{1, 0}}, {{1, 1}}}), ParameterError);
    REQUIRE_THROWS_AS(boxDomain<3>(Box<3>{}), ParameterError);
    const auto ball = ballDomain<3>(1);
    REQUIRE_THROWS_AS(clippedDomain<3>(ball, {{{{0, 0, 0}}, 1}}), ParameterError);
    REQUIRE_THROWS_AS(clippedDomain<3>(ball, {{{{1, 0, 0}}, -1.5}}), InputError);
    REQUIRE_THROWS_AS(clippedDomain<3>(ball, {{{{1, 0, 0}}, 0}, {{{-1, 0, 0}}, -0.5}}), InputError);
    // Bounds overlap, the ball does not reach the corner that is kept.
    REQUIRE_THROWS_AS(clippedDomain<3>(ball, {{{{-1, -1, -1}}, -2}}), InputError);
}
