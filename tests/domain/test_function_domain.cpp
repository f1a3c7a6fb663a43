// Domains from a function: the same as shapes for their distances, and exact for packs.
#include "support/cube.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/function_domain.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/overlap.h"
#include "vdbpack/verify/protrusion.h"

namespace {

template <int Dim>
std::function<double(const Vec<Dim>&)> ball(double radius) {
    return [radius](const Vec<Dim>& x) { return length(x) - radius; };
}

/// Period 2 pi c; its gradient is at most sqrt(3) / c anywhere.
double gyroid(const Vec<3>& x, double c) {
    return std::sin(x[0] / c) * std::cos(x[1] / c) + std::sin(x[1] / c) * std::cos(x[2] / c) +
           std::sin(x[2] / c) * std::cos(x[0] / c);
}

/// A point on a sphere around the origin, evenly distributed.
Vec<3> direction(RandomStream& random) {
    for (;;) {
        const Vec<3> x{
            {2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1}};
        if (const double l = length(x); l > 0.1 && l < 1) return x * (1 / l);
    }
}

template <int Dim>
PackResult<Dim> packOf(const Domain<Dim>& domain, const char* sizes) {
    const PackOptions options(SizeDistribution::parse(sizes, Dim));
    return packSpheres(domain, options);
}

/// Largest value of a function on the surfaces of spheres, at random points.
template <class Function>
double largestOn(const std::vector<Sphere<3>>& spheres, const Function& f) {
    RandomStream random(5, 0);
    double most = -std::numeric_limits<double>::infinity();
    for (const auto& s : spheres)
        for (int k = 0; k < 100; ++k)
            most = std::max(most, f(s.center + direction(random) * s.radius));
    return most;
}

}  // namespace

DIM_TEST_CASE("a signed distance function is the domain of its shape") {
    const auto exact = ballDomain<Dim>(5);
    const auto domain = functionDomain<Dim>(ball<Dim>(5), cube<Dim>(11));
    CAPTURE(Dim);
    REQUIRE(domain->volume() == Approx(exact->volume()).epsilon(1e-3));
    REQUIRE(length(*domain->centroid()) < 1e-9);
    REQUIRE(domain->wallArea() == Approx(exact->wallArea()).epsilon(0.01));
    REQUIRE(domain->volumeDeeperThan(1) == Approx(exact->volumeDeeperThan(1)).epsilon(1e-3));
    const auto sampler = domain->sampler(), other = exact->sampler();
    RandomStream random(2, 0);
    for (int k = 0; k < 1000; ++k) {
        Vec<Dim> x;
        if (k > 0)  // the center has no nearest point of its own
            for (int i = 0; i < Dim; ++i) x[i] = 7 * (random.uniform() - 0.5);
        CAPTURE(k, x[0], x[1]);
        REQUIRE(sampler->contains(x) == other->contains(x));
        WallPoint<Dim> wall, expected;
        // The sides of the bounds are farther than the ball for a point inside.
        if (!other->contains(x)) continue;
        REQUIRE(sampler->signedDistance(x) == Approx(other->signedDistance(x)).margin(1e-12));
        REQUIRE(sampler->nearestWall(x, 10, wall));
        REQUIRE(other->nearestWall(x, 10, expected));
        REQUIRE(wall.distance == Approx(expected.distance).epsilon(1e-12));
        REQUIRE(length(wall.point - x) == Approx(wall.distance).epsilon(1e-12));
        REQUIRE(length(wall.point) == Approx(5).margin(1e-4));
        if (k > 0) REQUIRE(length(wall.point - expected.point) < 1e-3 * wall.distance);
        REQUIRE_FALSE(sampler->isWallCloser(x, expected.distance * (1 - 1e-9)));
    }
}

TEST_CASE("nothing protrudes from a function that is a signed distance") {
    // A ball whose lower part is cut off by the bounds.
    Box<3> bounds = cube<3>(20);
    bounds.lo[2] = -4;
    const auto domain = functionDomain<3>(ball<3>(8), bounds);
    const auto shape = clippedDomain<3>(ballDomain<3>(8), {{{{0, 0, -1}}, 4}});
    const auto packed = packOf(*domain, "uniform:0.5,1").pack.spheres;
    auto wall = WallShape<3>::ofBall(8);
    wall.clips.push_back({{{0, 0, -1}}, 4});
    CHECK(checkProtrusion(packed, wall).spheres == 0);
    CHECK(checkOverlap(packed).pairs == 0);
    CHECK(static_cast<double>(packed.size()) ==
          Approx(static_cast<double>(packOf(*shape, "uniform:0.5,1").pack.spheres.size()))
              .epsilon(0.02));

    const auto circles = packOf(*functionDomain<2>(ball<2>(20), cube<2>(50)), "uniform:0.5,1");
    CHECK(circles.pack.spheres.size() > 500);
    CHECK(checkProtrusion(circles.pack.spheres, WallShape<2>::ofBall(20)).spheres == 0);
    CHECK(checkOverlap(circles.pack.spheres).pairs == 0);
}

TEST_CASE("a gyroid divided by its largest gradient keeps spheres inside") {
    const double c = 3;
    const auto f = [c](const Vec<3>& x) { return gyroid(x, c); };
    FunctionOptions options;
    options.steepest = std::sqrt(3.0) / c;
    const auto domain = functionDomain<3>(f, cube<3>(2 * kPi * c), options);
    CHECK(domain->volume() == Approx(std::pow(2 * kPi * c, 3) / 2).epsilon(1e-3));
    const auto packed = packOf(*domain, "uniform:0.4,0.8").pack.spheres;
    CHECK(packed.size() > 500);
    CHECK(largestOn(packed, f) < 1e-9);
    CHECK(checkProtrusion(packed, WallShape<3>::ofBox(cube<3>(2 * kPi * c))).spheres == 0);
    CHECK(checkOverlap(packed).pairs == 0);
}

TEST_CASE("the contour of a gyroid holds a pack as close as its voxels allow") {
    const double c = 3;
    const auto f = [c](const Vec<3>& x) { return gyroid(x, c); };
    FunctionOptions options;
    options.steepest = std::sqrt(3.0) / c;
    FieldOptions field;
    field.voxelSize = 0.25;
    field.depth = 2.4;
    field.detail = 0.4;
    const Box<3> bounds = cube<3>(2 * kPi * c);
    const auto domain = implicitDomain(f, bounds, options, field);
    CHECK(domain->volume() == Approx(std::pow(2 * kPi * c, 3) / 2).epsilon(0.01));
    const auto packed = packOf(*domain, "uniform:0.4,0.8").pack.spheres;
    CHECK(checkOverlap(packed).pairs == 0);
    CHECK(checkProtrusion(packed, WallShape<3>::ofBox(bounds)).spheres == 0);
    // A curvature of the surface of at most 1 / c: voxels of 0.25 are off by about 0.01 mm.
    CHECK(largestOn(packed, f) / options.steepest < 0.02);
    // Denser than what lower bounds of the distance allow.
    CHECK(packed.size() >
          packOf(*functionDomain<3>(f, bounds, options), "uniform:0.4,0.8").pack.spheres.size());
    CHECK(sliceDomain(domain, 1)->volume() > 0);
}

TEST_CASE("functions that are no domain are refused") {
    const Box<3> bounds = cube<3>(11);
    const auto f = ball<3>(5);
    FunctionOptions options;
    options.name = "mine";
    REQUIRE_THROWS_AS(functionDomain<3>(nullptr, bounds), ParameterError);
    REQUIRE_THROWS_AS(functionDomain<3>(f, Box<3>{}), ParameterError);
    REQUIRE_THROWS_AS(implicitDomain(f, Box<3>{}, options, {}), ParameterError);
    options.steepest = 0;
    REQUIRE_THROWS_AS(functionDomain<3>(f, bounds, options), ParameterError);
    options.steepest = 1;
    const auto outside = [](const Vec<3>&) { return 1.0; };
    REQUIRE_THROWS_AS(functionDomain<3>(outside, bounds, options), InputError);
    const auto steep = [&](const Vec<3>& x) { return 2 * f(x); };
    const auto notFinite = [](const Vec<3>& x) { return x[0] / std::abs(x[0]); };
    for (const auto& message :
         {messageOf<InputError>([&] { functionDomain<3>(steep, bounds, options); }),
          messageOf<InputError>([&] { functionDomain<3>(notFinite, bounds, options); })}) {
        CAPTURE(message);
        REQUIRE(message.find("mine") != std::string::npos);
    }
    REQUIRE(messageOf<InputError>([&] {
                functionDomain<3>(steep, bounds, options);
            }).find("`steepest`") != std::string::npos);
    REQUIRE_THROWS_AS(sliceDomain(functionDomain<3>(f, bounds), 0), ParameterError);
}
