#include "support/test.h"

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/rng.h"

DIM_TEST_CASE("distances to an ellipsoid are those to its nearest point") {
    RandomStream random(5, Dim);
    for (int round = 0; round < 60; ++round) {
        Ellipsoid<Dim> e;
        e.a = std::pow(10.0, 2 * random.uniform() - 1);
        e.b = round % 10 == 0 ? e.a : std::pow(10.0, 2 * random.uniform() - 1);
        if constexpr (Dim == 3)
            e.axis = axisOf(7 * random.uniform(), 7 * random.uniform());
        else
            e.axis = axisOf(7 * random.uniform());
        for (int d = 0; d < Dim; ++d) e.center[d] = 10 * random.uniform() - 5;
        CHECK(length(e.axis) == Approx(1));
        const double large = std::max(e.a, e.b);
        CAPTURE(Dim, round, e.a, e.b);
        for (int k = 0; k < 40; ++k) {
            Vec<Dim> x = e.center;
            for (int d = 0; d < Dim; ++d) x[d] += 3 * large * (random.uniform() - 0.5);
            if (k == 0) x = e.center;
            if (k == 1) x = e.center + e.axis * (0.5 * e.a);
            // The plane of the axis and the point holds the nearest point: an ellipse, by steps.
            const Vec<Dim> to = x - e.center;
            const double along = std::fabs(dot(to, e.axis));
            const double across = std::sqrt(std::max(0.0, squaredLength(to) - along * along));
            double nearest = std::numeric_limits<double>::infinity();
            const auto at = [&](double t) {
                return std::hypot(e.a * std::cos(t) - along, e.b * std::sin(t) - across);
            };
            double best = 0;
            for (int i = 0; i <= 2000; ++i)
                if (const double t = 0.5 * kPi * i / 2000; at(t) < nearest) nearest = at(best = t);
            for (double step = kPi / 4000; step > 1e-10; step *= 0.5)
                for (const double t : {best - step, best + step})
                    if (at(t) < nearest) nearest = at(best = t);
            const bool inside = along * along / (e.a * e.a) + across * across / (e.b * e.b) < 1;
            CHECK(e.contains(x) == inside);
            CHECK(e.signedDistance(x) == Approx(inside ? -nearest : nearest).margin(1e-6 * large));
        }
        // The box touches it on every side, where its surface stands across the axis.
        const auto box = e.bounds();
        for (int d = 0; d < Dim; ++d) {
            Vec<Dim> touch = e.axis * ((e.a * e.a - e.b * e.b) * e.axis[d]);
            touch[d] += e.b * e.b;
            touch *= 1 / (box.hi[d] - e.center[d]);
            CHECK(e.contains(e.center + touch * (1 - 1e-6)));
            CHECK_FALSE(e.contains(e.center + touch * (1 + 1e-6)));
            CHECK(touch[d] == Approx(box.hi[d] - e.center[d]));
            CHECK(box.hi[d] + box.lo[d] == Approx(2 * e.center[d]).margin(1e-9));
        }
    }
}

TEST_CASE("the axis of a void is turned as its angles say") {
    CHECK(axisOf(0, 0)[2] == Approx(1));
    CHECK(length(axisOf(0, kPi / 2) - Vec<3>{{0, -1, 0}}) < 1e-12);
    CHECK(length(axisOf(kPi / 2, kPi / 2) - Vec<3>{{1, 0, 0}}) < 1e-12);
    CHECK(length(axisOf(kPi / 2) - Vec<2>{{0, 1}}) < 1e-12);
}
