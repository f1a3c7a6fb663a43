#include "support/generators.h"
#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/voids/void_field.h"
#include "vdbpack/voids/void_list.h"

namespace {

template <int Dim>
VoidShape<Dim> shapeOf(const std::string& radius, const std::string& aspect, const Box<Dim>& bounds,
                       const std::string& angles = "isotropic") {
    OrientationRecipe orientation;
    orientation.angles = VoidAngles::parse(angles);
    return {SizeDistribution::parse(radius, Dim), SizeDistribution::parse(aspect, Dim),
            makeOrientation<Dim>(orientation, bounds)};
}

template <int Dim>
bool same(const Ellipsoid<Dim>& a, const Ellipsoid<Dim>& b) {
    return a.center == b.center && a.a == b.a && a.b == b.b && a.axis == b.axis;
}

template <int Dim>
bool same(const std::vector<Ellipsoid<Dim>>& a, const std::vector<Ellipsoid<Dim>>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const auto& x, const auto& y) { return same(x, y); });
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("overlapping voids leave the share exp(-n v)", "[long]", ((int Dim), Dim), 2,
                       3) {
    const double share = GENERATE(0.05, 0.15, 0.36);
    const auto seed = GENERATE(1u, 2u, 3u);
    // One realization scatters by about sqrt(p (1 - p) v / V): 0.002 in a cube of 40 half-axes. A
    // square of 40 would give 0.015, too much for this test; hence 400 in the plane.
    const double halfAxis = 1, side = (Dim == 3 ? 40 : 400) * halfAxis;
    const auto domain = boxDomain<Dim>(cube<Dim>(side));
    const auto shape = shapeOf<Dim>("constant:0.5", "constant:2", domain->bounds());
    REQUIRE(shape.reach() == halfAxis);
    REQUIRE(shape.meanMeasure() == Approx(Dim == 3 ? kPi / 3 : kPi / 2));
    const auto voids =
        booleanVoids<Dim>({*domain}, shape, seed, -std::log(share) / shape.meanMeasure());
    const auto stamped = stampVoids(voids, *domain, stampOptions(*domain, 0.25));
    const double solid = 1 - stamped->volume() / domain->volume();
    INFO("solid fraction " << solid << " for " << share << ", off by " << solid - share);
    CHECK(std::fabs(solid - share) < 0.01);
}

DIM_TEST_CASE("voids of many sizes leave the share exp(-n v) of their mean measure") {
    const double side = Dim == 3 ? 40 : 300;
    const auto domain = ballDomain<Dim>(side / 2);
    const auto shape = shapeOf<Dim>("uniform:0.3,1", "uniform:0.5,2", domain->bounds(),
                                    Dim == 3 ? "tz=uniform:0,6.28;tx=0.3" : "phi=uniform:0,1");
    // The same by number: the mean of a b^(Dim-1), drawn apart.
    const double b = Dim == 3 ? (1 - std::pow(0.3, 4)) / 4 / 0.7 : (1 - 0.027) / 3 / 0.7;
    CHECK(shape.meanMeasure() == Approx(1.25 * b * Measure<Dim>::ball(1)).epsilon(1e-4));
    const double shell = 2;
    const VoidRegion<Dim> region{*domain, shell};
    const auto voids = booleanVoids<Dim>(region, shape, 4, -std::log(0.2) / shape.meanMeasure());
    const auto stamped = stampVoids(voids, *domain, stampOptions(*domain, 0.25, shell));
    // As thin next to the shell as in the middle: centers lie beyond it, too.
    CHECK(1 - stamped->volume() / region.volume() == Approx(0.2).margin(0.01));
}

DIM_TEST_CASE("voids are the same for any number of threads") {
    const auto domain = boxDomain<Dim>(cube<Dim>(Dim == 3 ? 30 : 200));
    const auto shape = shapeOf<Dim>("uniform:0.3,1", "uniform:1,3", domain->bounds());
    const double density = Dim == 3 ? 1.2 : 0.8;
    const auto draw = [&](double n) { return booleanVoids<Dim>({*domain, 1}, shape, 9, n); };
    const auto voids = withThreads(1, [&] { return draw(density); });
    REQUIRE(voids.size() > 20000);
    for (const int threads : {2, 3, 8})
        CHECK(same(withThreads(threads, [&] { return draw(density); }), voids));
    CHECK_FALSE(same(booleanVoids<Dim>({*domain, 1}, shape, 10, density), voids));
    // The first ones of a denser list.
    const auto thin = draw(density / 3);
    REQUIRE(thin.size() < voids.size());
    CHECK(std::equal(thin.begin(), thin.end(), voids.begin(),
                     [](const auto& a, const auto& b) { return same(a, b); }));
}

DIM_TEST_CASE("all listed voids can reach deeper than the shell") {
    const double shell = GENERATE(0.0, 1.0);
    const auto check = [&](const Domain<Dim>& domain) {
        CAPTURE(domain.facts().kind, shell);
        const auto shape = shapeOf<Dim>("uniform:0.5,0.8", "uniform:1,2", domain.bounds());
        const auto voids = booleanVoids<Dim>({domain, shell}, shape, 3, 2000 / domain.volume());
        REQUIRE(voids.size() > 1000);
        const auto sampler = domain.sampler();
        for (const auto& e : voids) {
            WallPoint<Dim> wall;
            if (sampler->contains(e.center)) continue;
            CAPTURE(e.center.c, e.a, e.b);
            REQUIRE(sampler->nearestWall(e.center, std::max(e.a, e.b) - shell + 1e-3, wall));
        }
    };
    check(*ballDomain<Dim>(10));
    check(*boxDomain<Dim>(cube<Dim>(16)));
    FieldOptions options;
    options.voxelSize = 0.3;  // the field knows distances outside to 0.45 mm
    options.depth = 3;
    const auto mesh = meshDomain(torusMesh(10, 4, 96, 48), options);
    if constexpr (Dim == 3)
        check(*mesh);
    else
        check(*sliceDomain(mesh, 0.3));
}

DIM_TEST_CASE("an ellipsoid fills each box that a matrix selects") {
    VoidMatrix matrix;
    matrix.size = {4, 3, Dim == 3 ? 2 : 1};
    matrix.cells = {1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1};
    if (Dim == 3) matrix.cells.insert(matrix.cells.end(), {0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0});
    Box<Dim> box;
    box.lo = Box<Dim>::filled(-2);
    box.hi[0] = 18;  // boxes of 5 by 3 (by 4) mm
    box.hi[1] = 7;
    if (Dim == 3) box.hi[2] = 6;
    const auto domain = boxDomain<Dim>(box);
    const auto lattice = voidLattice<Dim>(box, {}, &matrix);
    const auto voids = latticeVoids<Dim>({*domain}, lattice, &matrix, 1, 1);
    REQUIRE(voids.size() ==
            static_cast<std::size_t>(std::count(matrix.cells.begin(), matrix.cells.end(), 1)));
    double sum = 0;
    std::vector<std::uint8_t> seen(matrix.cells.size());
    for (const auto& e : voids) {
        sum += e.volume();
        // In 5 by 3 by 4 mm a flat one is larger than a long one.
        CHECK(e.a == Approx(Dim == 2 ? 2.5 : 1.5));
        CHECK(e.b == Approx(Dim == 2 ? 1.5 : 2));
        CHECK(std::fabs(e.axis[Dim == 2 ? 0 : 1]) == 1);
        std::array<int, 3> at{};
        for (int d = 0; d < Dim; ++d) {
            const double side = d == 0 ? 5 : d == 1 ? 3 : 4;
            const double place = (e.center[d] + 2) / side - 0.5;
            CHECK(place == Approx(std::round(place)).margin(1e-9));
            at[static_cast<std::size_t>(d)] = static_cast<int>(std::round(place));
        }
        CHECK(matrix.at(at[0], at[1], at[2]));
    }
    // The holes cover what the ellipses do: they lie apart.
    const auto stamped = stampVoids(voids, *domain, stampOptions(*domain, 0.1));
    CHECK(stamped->volume() == Approx(sum).epsilon(0.01));
}

DIM_TEST_CASE("boxes kept at a smaller probability are a subset of those kept at a larger one") {
    const auto domain = boxDomain<Dim>(cube<Dim>(Dim == 3 ? 20 : 80));
    const std::vector<double> cell =
        Dim == 3 ? std::vector<double>{1, 0.8, 1} : std::vector<double>{1, 0.8};
    const double h = Dim == 3 ? 0.1 : 0.06;
    const auto lattice = voidLattice<Dim>(domain->bounds(), cell, nullptr);
    const double boxes = Dim == 3 ? 20 * 25 * 20 : 80 * 100;
    std::vector<Ellipsoid<Dim>> before;
    for (const double p : {0.0, 0.1, 0.37, 0.9, 1.0}) {
        const auto voids = latticeVoids<Dim>({*domain}, lattice, nullptr, p, 6);
        CHECK(static_cast<double>(voids.size()) / boxes ==
              Approx(p).margin(4 * std::sqrt(p * (1 - p) / boxes)));
        for (const auto& e : before)
            REQUIRE(std::any_of(voids.begin(), voids.end(),
                                [&](const auto& other) { return same(e, other); }));
        double sum = 0;
        for (const auto& e : voids) sum += e.volume();
        if (p > 0)
            CHECK(stampVoids(voids, *domain, stampOptions(*domain, h))->volume() ==
                  Approx(sum).epsilon(0.01));
        before = voids;
        if (before.size() > 1000) before.resize(1000);
    }
    CHECK_FALSE(same(latticeVoids<Dim>({*domain}, lattice, nullptr, 0.37, 6),
                     latticeVoids<Dim>({*domain}, lattice, nullptr, 0.37, 7)));
}

TEST_CASE("a matrix smaller than the lattice repeats, a single layer applies to all") {
    VoidMatrix matrix;
    matrix.size = {2, 2, 1};
    matrix.cells = {1, 0, 0, 1};
    const auto plane = boxDomain<2>(cube<2>(8));
    const auto lattice = voidLattice<2>(plane->bounds(), {2}, &matrix);
    CHECK(lattice.count[0] == 4);
    const auto voids = latticeVoids<2>({*plane}, lattice, &matrix, 1, 1);
    REQUIRE(voids.size() == 8);
    for (const auto& e : voids) {
        const int i = static_cast<int>((e.center[0] + 4) / 2),
                  j = static_cast<int>((e.center[1] + 4) / 2);
        CHECK((i + j) % 2 == 0);
    }
    const auto space = boxDomain<3>(cube<3>(8));
    const auto cubes = voidLattice<3>(space->bounds(), {}, &matrix);
    CHECK(cubes.count == std::array<std::int64_t, 3>{2, 2, 2});
    CHECK(latticeVoids<3>({*space}, cubes, &matrix, 1, 1).size() == 4);
    const auto refuse = [&](const std::vector<double>& cell) {
        return messageOf<ParameterError>([&] { voidLattice<3>(space->bounds(), cell, nullptr); });
    };
    const double inf = std::numeric_limits<double>::infinity();
    for (const auto& cell :
         std::vector<std::vector<double>>{{0}, {-1}, {1, 2}, {1, 2, 3, 4}, {std::nan("")}, {inf}}) {
        CAPTURE(cell);
        CHECK_THAT(refuse(cell), Contains("`cell`"));
    }
    CHECK_THROWS_AS(voidLattice<3>(space->bounds(), {1e-4}, nullptr), ResourceError);
}

DIM_TEST_CASE("ellipsoids lie inside spheres or enclose them") {
    std::vector<Sphere<Dim>> spheres(500);
    RandomStream random(14, Dim);
    for (auto& s : spheres) {
        s.center = randomPoint(random, cube<Dim>(40));
        s.radius = 1 + random.uniform();
    }
    const auto shape = shapeOf<Dim>("constant:1", "uniform:0.5,3", cube<Dim>(40));
    const auto inside = voidsAtSpheres(spheres, true, shape, 3);
    const auto about = voidsAtSpheres(spheres, false, shape, 3);
    REQUIRE(inside.size() == 500);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        CHECK(inside[i].center == spheres[i].center);
        CHECK(std::max(inside[i].a, inside[i].b) == Approx(spheres[i].radius));
        CHECK(inside[i].a / inside[i].b == Approx(about[i].a / about[i].b));
        CHECK(about[i].b == spheres[i].radius);
        CHECK(inside[i].axis == about[i].axis);
    }
    auto mixed = inside;
    shuffle(mixed, 5);
    auto again = inside;
    shuffle(again, 5);
    CHECK(same(mixed, again));
    CHECK_FALSE(same(mixed, inside));
    const auto byPlace = [](const auto& a, const auto& b) { return a.center.c < b.center.c; };
    auto sorted = inside;
    std::sort(sorted.begin(), sorted.end(), byPlace);
    std::sort(mixed.begin(), mixed.end(), byPlace);
    CHECK(same(sorted, mixed));
}
