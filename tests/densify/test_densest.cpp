// Packs as dense as they can be, and requests beyond that.
#include "densify/densifying.h"
#include "support/test.h"

#include "vdbpack/measure/bond_order.h"

TEST_CASE("equal spheres get denser without crystallizing", "[long]") {
    const auto domain = box<3>(40);
    const auto before = front(*domain, "constant:1");
    struct Case {
        double fraction, most;  // share in crystalline order
    };
    for (const Case& c : {Case{0.6, 0.02}, Case{kMax, 0.08}}) {
        CAPTURE(c.fraction);
        double share = 0;  // of three seeds
        auto options = to<3>(c.fraction, "constant:1");
        for (options.seed = 1; options.seed <= 3; ++options.seed) {
            const auto result = densify(*domain, before, options);
            CHECK(result.after > (c.fraction == kMax ? 0.608 : 0.5999));
            share += solidLikeShare(result.spheres) / 3;
            checkSound(result.spheres, *domain);
        }
        CHECK(share < c.most);
    }
}

TEST_CASE("equal spheres without walls get as dense as random packs can be") {
    const PeriodicCell<3> cell{{{}, {{24, 24, 24}}}, {true, true, true}};
    const auto domain = periodicDomain(cell);
    const auto before = front(*domain, "constant:1");
    const auto result = densify(*domain, before, to<3>(kMax, "constant:1"));
    CHECK(result.after > 0.635);
    CHECK(solidLikeShare(result.spheres, cell) < 0.03);
    CHECK(checkOverlap(result.spheres, cell).max == 0);
}

TEST_CASE("in a cell, too, a request out of reach ends no less dense than the densest pack") {
    const std::string spec = GENERATE(as<std::string>{}, "constant:1", "uniform:1,2");
    const PeriodicCell<3> cell{{{}, {{20, 20, 20}}}, {true, true, true}};
    const auto domain = periodicDomain(cell);
    const auto before = front(*domain, spec);
    const auto densest = densify(*domain, before, to<3>(kMax, spec));
    const auto beyond = densify(*domain, before, to<3>(0.8, spec));
    CHECK_FALSE(beyond.reached);
    CHECK(beyond.after >= densest.after);
}

TEST_CASE("equal spheres of a loose pack get as dense as those of a front", "[long]") {
    const auto domain = box<3>(30);
    auto before = front(*domain, "constant:1");
    for (std::size_t i = 0; 3 * i + 2 < before.size(); ++i)
        before.erase(before.begin() + static_cast<std::ptrdiff_t>(2 * i));
    const auto result = densify(*domain, before, to<3>(kMax, "constant:1"));
    CHECK(result.before < 0.45);
    CHECK(result.after > 0.58);
    checkSound(result.spheres, *domain);
}

DIM_TEST_CASE("a request out of reach ends no less dense than the densest pack") {
    const std::string spec = "uniform:1,2";
    const auto domain = box<Dim>(Dim == 3 ? 24 : 60);
    const auto before = front(*domain, spec);
    const auto densest = densify(*domain, before, to<Dim>(kMax, spec));
    CHECK(densest.after > densest.before + 0.005);
    checkSound(densest.spheres, *domain);
    for (const double wanted : {densest.after + 0.01, densest.after + 0.05, 0.93}) {
        CAPTURE(Dim, wanted, densest.after);
        const auto result = densify(*domain, before, to<Dim>(wanted, spec));
        CHECK(result.after >= densest.after);
        CHECK(result.reached == (result.after >= wanted));
        checkSound(result.spheres, *domain);
    }
}
