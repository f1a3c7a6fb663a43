#include "measure/packs.h"
#include "support/ball_domain.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/measure/vacancies.h"

#include <tuple>

namespace {

/// A ball whose signed distance is cut off at a depth, as that of a mesh is.
ChangedBall shallowBall(double radius, double known) {
    return {radius, known, 0, [known](double d) { return std::clamp(d, -known, 0.5); }};
}

/// Share of the ball of radius `R` covered by lattice spheres of radius 1, by plain sampling.
double sampledFraction(const std::vector<Sphere<3>>& spheres, double R) {
    RandomStream random(3, 3);
    int inside = 0, covered = 0;
    while (inside < 40000) {
        Vec<3> x;
        for (int i = 0; i < 3; ++i) x[i] = (2 * random.uniform() - 1) * R;
        if (squaredLength(x) > R * R) continue;
        ++inside;
        covered += std::any_of(spheres.begin(), spheres.end(), [&](const Sphere<3>& s) {
            return squaredLength(x - s.center) < s.radius * s.radius;
        });
    }
    return static_cast<double>(covered) / inside;
}

}  // namespace

TEST_CASE("lattices fill what crystallography says") {
    const auto [lattice, expected] =
        GENERATE(std::make_tuple(Lattice::sc, kPi / 6),
                 std::make_tuple(Lattice::bcc, kPi * std::sqrt(3.0) / 8),
                 std::make_tuple(Lattice::fcc, kPi / std::sqrt(18.0)));
    double edge = 0;
    const int cells = 14;
    const auto spheres = latticeSpheres(lattice, cells, edge);
    // Whole cells of the lattice, whose boundary the interior is cut along by the depth.
    const double border = 2 * edge;
    const auto domain = boxDomain<3>(Box<3>{{{0, 0, 0}}, Vec<3>{{1, 1, 1}} * (cells * edge)});
    REQUIRE(*interiorFraction(spheres, *domain, border) == Approx(expected).margin(2e-4));
    REQUIRE(solidFraction(spheres, *domain) == Approx(expected).epsilon(1e-12));
}

TEST_CASE("squares of circles fill a quarter of pi") {
    std::vector<Sphere<2>> circles = disjointSpheres<2>(30, 1);
    for (auto& c : circles) c.radius = 1;
    const auto domain = boxDomain<2>(Box<2>{{{0, 0}}, {{60, 60}}});
    REQUIRE(solidFraction(circles, *domain) == Approx(kPi / 4));
    REQUIRE(*interiorFraction(circles, *domain, 6.0) == Approx(kPi / 4).margin(2e-4));
    REQUIRE(*interiorFraction(circles, *domain, 5.0) == Approx(kPi / 4).margin(2e-4));
    REQUIRE_FALSE(interiorFraction(circles, *domain, 30.5));
}

TEST_CASE("a field that ends at the requested depth gives the same interior", "[long]") {
    double edge = 0;
    auto spheres = latticeSpheres(Lattice::fcc, 14, edge);
    for (auto& s : spheres) s.center -= Vec<3>{{1, 1, 1}} * (7 * edge);
    const double R = 18, depth = 3;
    const auto exact = interiorFraction(spheres, *ballDomain<3>(R), depth);
    const auto shallow = interiorFraction(spheres, shallowBall(R, depth), depth);
    const auto barely = interiorFraction(spheres, shallowBall(R, depth + 0.4), depth);
    REQUIRE(*exact == Approx(sampledFraction(spheres, R - depth)).margin(0.01));
    REQUIRE(*shallow == Approx(*exact).margin(1e-3));
    REQUIRE(*barely == Approx(*exact).margin(1e-3));
    REQUIRE_THROWS_AS(interiorFraction(spheres, shallowBall(R, depth), depth + 0.1),
                      ParameterError);
    REQUIRE_THROWS_AS(interiorFraction(spheres, *ballDomain<3>(R), -1.0), ParameterError);
}

TEST_CASE("the interior of a mesh is that of its shape, in voxels of any size") {
    // The layer that is deep enough is thinner than the coarser voxels.
    const double depth = GENERATE(1.5, 1.8);
    const Vec<3> half{{2, 15, 15}};
    const auto spheres = randomSpheres<3>(40000, 24, 0.2, 2, 5);
    const auto exact = boxDomain<3>({half * -1, half});
    const auto mesh = boxMesh(half * -1, half);
    const double expected = *interiorFraction(spheres, *exact, depth);
    for (const double voxelSize : {0.1, 0.31, 0.57}) {
        CAPTURE(depth, voxelSize);
        FieldOptions options;
        options.voxelSize = voxelSize;
        options.depth = depth;
        CHECK(*interiorFraction(spheres, *meshDomain(mesh, options), depth) ==
              Approx(expected).epsilon(0.025));
    }
}

TEST_CASE("an empty ball has its largest place in the middle") {
    const auto domain = ballDomain<3>(10, {{5, 6, 7}});
    const auto check = findVacancies<3>({}, *domain, 9.0, 200000);
    REQUIRE(check.largest <= 10);
    REQUIRE(check.largest > 10 - check.spacing);
    REQUIRE(length(check.at - Vec<3>{{5, 6, 7}}) < check.spacing);
    // Points within 1 of the middle: a thousandth of them all.
    REQUIRE(static_cast<double>(check.points) == Approx(200).epsilon(0.1));
}

DIM_TEST_CASE("a sphere taken out leaves a place of its size") {
    const int n = Dim == 2 ? 12 : 6;
    auto spheres = disjointSpheres<Dim>(n, 5);
    for (auto& s : spheres) s.radius = 1;
    Box<Dim> box{Box<Dim>::filled(0), Box<Dim>::filled(2.0 * n)};
    const auto domain = boxDomain<Dim>(box);
    const std::uint64_t points = 300000;
    // Between touching spheres of a square or cubic lattice: sqrt(Dim) - 1.
    auto check = findVacancies<Dim>(spheres, *domain, 0.75, points);
    REQUIRE(check.points == 0);
    REQUIRE(check.largest <= std::sqrt(Dim) - 1 + 1e-9);
    REQUIRE(check.largest > std::sqrt(Dim) - 1 - check.spacing);
    const auto at = spheres[spheres.size() / 2 + n / 2].center;
    spheres.erase(spheres.begin() + static_cast<std::ptrdiff_t>(spheres.size() / 2 + n / 2));
    check = findVacancies<Dim>(spheres, *domain, 0.75, points);
    REQUIRE(check.points > 0);
    REQUIRE(check.largest <= 1 + 1e-9);
    REQUIRE(check.largest > 1 - check.spacing);
    REQUIRE(length(check.at - at) < 2 * check.spacing);
}

TEST_CASE("places are those of a search over the same clearances") {
    const auto spheres = randomSpheres<3>(300, 18, 0.5, 8, 21);
    const auto domain = cylinderDomain(8, 14);
    const double radius = 1.2;
    const auto check = findVacancies<3>(spheres, *domain, radius, 400000);
    RandomStream random(8, 8);
    const auto sampler = domain->sampler();
    const auto clearance = [&](const Vec<3>& x) {
        double c = -sampler->signedDistance(x);
        for (const auto& s : spheres) c = std::min(c, length(x - s.center) - s.radius);
        return c;
    };
    REQUIRE(clearance(check.at) == Approx(check.largest).epsilon(1e-9));
    int inside = 0, places = 0;
    const Box<3> bounds = domain->bounds();
    while (inside < 40000) {
        Vec<3> x;
        for (int i = 0; i < 3; ++i)
            x[i] = bounds.lo[i] + random.uniform() * (bounds.hi[i] - bounds.lo[i]);
        if (!(sampler->signedDistance(x) < 0)) continue;
        ++inside;
        const double c = clearance(x);
        places += c >= radius;
        REQUIRE(c <= check.largest + check.spacing);
    }
    // Ten times fewer points at random: four standard errors.
    REQUIRE(static_cast<double>(check.points) / 10 ==
            Approx(places).margin(4 * std::sqrt(static_cast<double>(places)) + 4));
    REQUIRE_THROWS_AS(findVacancies<3>(spheres, *domain, 0.0), ParameterError);
}

DIM_TEST_CASE("the profile of a lattice is level in whole layers") {
    // Ten touching spheres a side: each layer of a diameter below the wall is a shell of whole
    // ones.
    std::vector<Sphere<Dim>> spheres;
    for (int z = 0; z < (Dim == 3 ? 10 : 1); ++z)
        for (int y = 0; y < 10; ++y)
            for (int x = 0; x < 10; ++x) {
                const int at[3] = {x, y, z};
                Sphere<Dim> s;
                for (int d = 0; d < Dim; ++d) s.center[d] = 2 * at[d] - 9;
                s.radius = 1;
                spheres.push_back(s);
            }
    const auto domain = boxDomain<Dim>({Box<Dim>::filled(-10), Box<Dim>::filled(10)});
    const double level = Measure<Dim>::ball(1) / std::pow(2, Dim);
    const auto layers = densityProfile(spheres, *domain, 2, 10);
    REQUIRE(layers.fraction.size() == 5);
    for (std::size_t b = 0; b < 5; ++b) {
        CAPTURE(b);
        CHECK(layers.error[b] < 0.003);
        CHECK(std::fabs(layers.fraction[b] - level) < 4 * layers.error[b] + 1e-9);
    }
    // Fine bins hold the same volume, and their errors are honest.
    const auto fine = densityProfile(spheres, *domain, 0.25, 10);
    REQUIRE(fine.fraction.size() == 40);
    double volume = 0;
    for (std::size_t b = 0; b < 40; ++b)
        volume += fine.fraction[b] *
                  (domain->volumeDeeperThan(0.25 * static_cast<double>(b)) -
                   domain->volumeDeeperThan(std::min(10.0, 0.25 * static_cast<double>(b + 1))));
    CHECK(volume ==
          Approx(static_cast<double>(spheres.size()) * Measure<Dim>::ball(1)).epsilon(1e-6));
    // The first bin: caps of height 0.25, where no second wall is near.
    const double edge = domain->volumeDeeperThan(0) - domain->volumeDeeperThan(0.25);
    const double cap = Dim == 3 ? kPi * 0.25 * 0.25 * (3 - 0.25) / 3
                                : std::acos(0.75) - 0.75 * std::sqrt(1 - 0.75 * 0.75);
    const double caps = (Dim == 3 ? 6 * 100 : 4 * 10) * cap;
    CHECK(std::fabs(fine.fraction[0] - caps / edge) < 4 * fine.error[0]);

    const auto local = localFraction(spheres, *domain, 4);
    REQUIRE(local);
    CHECK(local->cells == (Dim == 3 ? 27 : 9));
    CHECK(local->mean == Approx(level).epsilon(1e-6));
    CHECK(local->sd < 1e-6);
    // Cells that cut spheres contain as much, within the error of the sample points.
    const auto cut = localFraction(spheres, *domain, 3);
    REQUIRE(cut);
    CHECK(cut->mean == Approx(level).epsilon(0.05));
    CHECK_FALSE(localFraction(spheres, *domain, 19));
    CHECK_THROWS_AS(localFraction(spheres, *domain, 0), ParameterError);
    CHECK_THROWS_AS(densityProfile(spheres, *domain, 0, 5), ParameterError);
    CHECK_THROWS_AS(densityProfile(spheres, *domain, 2, 1), ParameterError);
}

DIM_TEST_CASE("the union of overlapping spheres is smaller than their sum") {
    const auto at = [](double x) {
        Sphere<Dim> sphere{{}, 1};
        sphere.center[0] = x;
        return sphere;
    };
    // Centers one radius apart: a lens of 5/12 pi (3D), of 2/3 pi - sqrt(3)/2 (2D), in both.
    const double lens = Dim == 3 ? 5.0 / 12 * kPi : 2.0 / 3 * kPi - std::sqrt(3) / 2;
    const double two = 1 - lens / (2 * Measure<Dim>::ball(1));
    CHECK(unionShare<Dim>({at(0), at(1)}) == Approx(two).margin(2e-3));
    CHECK(unionShare<Dim>({at(0), at(1), at(5), at(7)}) == Approx((1 + two) / 2).margin(2e-3));
    CHECK(unionShare<Dim>({at(0), at(0), at(0)}) == Approx(1.0 / 3));
    CHECK(unionShare<Dim>({at(0), at(2.5)}) == 1);
    PeriodicCell<Dim> cell;
    for (int d = 0; d < Dim; ++d) cell.box.lo[d] = -5, cell.box.hi[d] = 5;
    cell.wraps[0] = true;
    CHECK(unionShare<Dim>({at(-4.5), at(4.5)}, cell) == Approx(two).margin(2e-3));
}
