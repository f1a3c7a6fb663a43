// Packs that begin with spheres at random points instead of a front.
#include "densify/densifying.h"
#include "support/test.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/function_domain.h"
#include "vdbpack/measure/contacts.h"

#include <cmath>

namespace {

template <int Dim>
DensifyOptions atRandomTo(double fraction, const std::string& spec) {
    auto options = to<Dim>(fraction, spec);
    options.random = true;
    return options;
}

}  // namespace

DIM_TEST_CASE("packs from random points have the solid fraction and the sizes asked for") {
    const double side = Dim == 3 ? 36 : 150;
    const double dense = Dim == 3 ? 0.62 : 0.82;
    const auto domain = box<Dim>(side, Box<Dim>::filled(100));
    for (const double fraction : {0.3, dense}) {
        CAPTURE(fraction);
        const std::string spec = "uniform:1,2";
        const auto result = densify(*domain, {}, atRandomTo<Dim>(fraction, spec));
        CHECK(result.apart);
        CHECK(result.reached);
        CHECK(result.after == Approx(fraction).margin(Measure<Dim>::ball(2) / domain->volume()));
        checkSound(result.spheres, *domain);
        const auto sizes = sizesOf(spec, Dim);
        std::vector<double> radii = radiiOf(result.spheres);
        std::sort(radii.begin(), radii.end());
        const auto n = static_cast<double>(radii.size());
        double off = 0;  // the largest distance of the two distributions
        for (std::size_t i = 0; i < radii.size(); ++i)
            off =
                std::max(off, std::fabs(sizes.cdf(radii[i]) - (static_cast<double>(i) + 0.5) / n));
        CHECK(off < 3 / n);
    }
}

TEST_CASE("packs from random points are the same on any number of threads") {
    const auto domain = box<3>(24);
    std::vector<std::vector<Sphere<3>>> packs;
    for (const int threads : {1, 3})
        withThreads(threads, [&] {
            packs.push_back(densify(*domain, {}, atRandomTo<3>(kMax, "uniform:1,2")).spheres);
        });
    CHECK((packs[0] == packs[1]));
    auto options = atRandomTo<3>(kMax, "uniform:1,2");
    options.seed = 2;
    CHECK_FALSE((densify(*domain, {}, options).spheres == packs[0]));
}

TEST_CASE("spheres from random points fill thin places about as densely as thick ones") {
    const auto outside = [](const Vec<3>& x, const Box<3>& box) {
        double most = -100;
        for (int d = 0; d < 3; ++d) most = std::max({most, box.lo[d] - x[d], x[d] - box.hi[d]});
        return most;
    };
    const Box<3> thick{{{-28, -14, -14}}, {{1, 14, 14}}}, thin{{{-1, -4, -4}}, {{40, 4, 4}}};
    const auto joined = functionDomain<3>(
        [&](const Vec<3>& x) { return std::min(outside(x, thick), outside(x, thin)); },
        {{{-28, -14, -14}}, {{40, 14, 14}}});
    const auto result = densify(*joined, {}, atRandomTo<3>(0.5, "uniform:0.8,1.2"));
    REQUIRE(result.reached);
    double volume = 0;
    for (const auto& s : result.spheres)
        if (s.center[0] > 5) volume += Measure<3>::ball(s.radius);
    CHECK(volume / (35 * 8 * 8) > 0.43);  // 0.35 if they had to lie inside at first
}

TEST_CASE(
    "where a solid fraction is out of reach, packs from random points are as dense as can be") {
    const std::string spec = GENERATE(as<std::string>{}, "constant:1", "uniform:1,2");
    const auto domain = box<3>(24);
    const auto densest = densify(*domain, {}, atRandomTo<3>(kMax, spec));
    CHECK(densest.after > (spec == "constant:1" ? 0.56 : 0.62));
    const auto beyond = densify(*domain, {}, atRandomTo<3>(0.8, spec));
    CHECK_FALSE(beyond.reached);
    CHECK(beyond.after >= densest.after - 0.01);
    checkSound(beyond.spheres, *domain);
}

TEST_CASE("packs from random points keep gaps, and repeat in a cell") {
    const PeriodicCell<3> cell{{{}, {{24, 24, 24}}}, {true, true, true}};
    const auto domain = periodicDomain(cell);
    auto options = atRandomTo<3>(0.6, "uniform:1,2");
    options.gap = 0.05;
    const auto result = densify(*domain, {}, options);
    REQUIRE(result.reached);
    CHECK(smallestGap(result.spheres, 0, cell).value() >= 0.05);
}

TEST_CASE("random points are refused beside a pack, and where radii have no room") {
    const auto domain = box<3>(24);
    CHECK_THROWS_AS(densify<3>(*domain, {{{}, 1}}, atRandomTo<3>(0.5, "constant:1")),
                    ParameterError);
    CHECK_THROWS_AS(densify<3>(*domain, {}, atRandomTo<3>(0, "constant:1")), ParameterError);
    CHECK_THROWS_AS(densify<3>(*domain, {}, atRandomTo<3>(0.5, "")), ParameterError);
    for (const char* const spec : {"constant:200", "constant:12.2"})
        CHECK_THROWS_AS(densify<3>(*domain, {}, atRandomTo<3>(0.5, spec)), InputError);
    const auto slab = boxDomain<3>({{{0, 0, 0}}, {{20, 20, 2}}});
    CHECK_THROWS_AS(densify<3>(*slab, {}, atRandomTo<3>(0.3, "uniform:1,1.2")), InputError);
    CHECK(densify<3>(*slab, {}, atRandomTo<3>(0.3, "constant:0.95")).reached);
}
