// Voids blended into one another, and struts between them.
#include "support/test.h"
#include "voids/stamping.h"

namespace {

template <int Dim>
std::vector<const Ellipsoid<Dim>*> pointersTo(const std::vector<Ellipsoid<Dim>>& voids) {
    std::vector<const Ellipsoid<Dim>*> all;
    for (const auto& e : voids) all.push_back(&e);
    return all;
}

/// A ball of radius 1 at `x` along the first axis.
template <int Dim>
Ellipsoid<Dim> ballAt(double x, std::uint32_t id = 0) {
    Ellipsoid<Dim> e;
    e.center[0] = x;
    e.a = e.b = 1;
    e.axis[0] = 1;
    e.id = id;
    return e;
}

}  // namespace

DIM_TEST_CASE("voids that come near or overlap are joined as joinedDistance says") {
    Scene<Dim> scene(0.2);
    const double h = scene.options.voxelSize;
    VoidJoin& how = scene.options.join;
    how = GENERATE(VoidJoin{0.05, 0, 1}, VoidJoin{0.3, 0, 1}, VoidJoin{0, 0.4, 1},
                   VoidJoin{0.1, 0.3, 0.5});
    CAPTURE(how.blend, how.strut, how.strutShare);
    const auto stamped = scene.stamp();
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    const auto voids = pointersTo(scene.voids);
    RandomStream random(6, Dim);
    std::size_t between = 0, struts = 0;
    for (int i = 0; i < 8000; ++i) {
        const Vec<Dim> x = voxelAt(randomPoint(random, cube<Dim>(19.8)), scene.options);
        const double exact = joinedDistance(voids, x, how);
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& e : scene.voids) nearest = std::min(nearest, e.signedDistance(x));
        if (how.strut == 0) REQUIRE(exact <= nearest + 1e-12);
        // Deep in voids, those farther away are not blended.
        const double tolerance = exact < -2.5 * h && how.strut > 0 ? 2e-2 : 4e-3;
        CAPTURE(exact, nearest);
        REQUIRE(std::fabs(distance(x) - std::max(-3 * h, std::min(exact, 3 * h))) < tolerance);
        if (std::fabs(exact) < 4e-3) continue;
        REQUIRE((distance(x) < 0) == (exact < 0));
        if (std::fabs(exact) < h) REQUIRE(stamped->isIn(scene.voids, x) == (exact < 0));
        between += exact < 0 && nearest > 0;
        struts += exact > 0 && nearest < 0;
    }
    CHECK(between >= (how.blend > 0.2 ? 40 : how.blend > 0 ? 1 : 0));
    CHECK((struts > 0) == (how.strut > 0));
}

DIM_TEST_CASE("blended, one void is what it was, and two that touch have merged") {
    const VoidJoin how{0.2, 0, 1};
    const auto left = ballAt<Dim>(-1), right = ballAt<Dim>(1), far = ballAt<Dim>(40);
    Vec<Dim> x;
    x[0] = -2.1;
    CHECK(joinedDistance<Dim>({&left}, x, how) == Approx(0.1));
    CHECK(joinedDistance<Dim>({&left, &far}, x, how) == Approx(0.1));
    CHECK(joinedDistance<Dim>({&left, &right}, {}, how) < 0);
}

DIM_TEST_CASE("a strut is as thick as asked, and lines have one by their share") {
    // Voids at equal angles about a line through the origin, far larger than the strut.
    const double far = 50, depth = GENERATE(0.5, 5.0);
    int kept = 0;
    const int trials = 400;
    for (int trial = 0; trial < trials; ++trial) {
        std::vector<Ellipsoid<Dim>> voids;
        for (int k = 0; k < Dim; ++k) {
            Ellipsoid<Dim> e = ballAt<Dim>(0, static_cast<std::uint32_t>(trial * Dim + k));
            const double angle = 2 * kPi * k / Dim;
            e.center[0] = far * std::cos(angle);
            e.center[1] = far * std::sin(angle);
            e.a = e.b = far + depth;
            voids.push_back(e);
        }
        const auto all = pointersTo(voids);
        VoidJoin how{0, 0.4, 0.3};
        kept += joinedDistance<Dim>(all, {}, how) > 0;
        how.strutShare = 1;
        for (const double angle : {0.1, 1.0, 2.5}) {
            // 2D: across the line where both are equally near.
            Vec<Dim> across;
            across[0] = Dim == 2 ? 1 : std::cos(angle);
            across[1] = Dim == 2 ? 0 : std::sin(angle);
            CHECK(joinedDistance<Dim>(all, across * 0.38, how) > 0);
            CHECK(joinedDistance<Dim>(all, across * 0.42, how) < 0);
        }
        how.strutShare = 0;
        CHECK(joinedDistance<Dim>(all, {}, how) == Approx(-depth));
    }
    CHECK(kept == Approx(0.3 * trials).margin(40));
}
