// The search that fits foams, on functions whose solution is known.
#include "support/test.h"

#include "vdbpack/voids/knob_search.h"

namespace {

/// A scale and two knobs between -2 and 2.
std::vector<Knob> threeKnobs() {
    return {{0, 1e6, -40, 40, 0.05, 0.5}, {0, 3, -2, 2, 0.1, 0.5}, {0, 3, -2, 2, 0.1, 0.5}};
}

/// A length, its cube's inverse, and a number that no length changes.
std::optional<std::vector<double>> numbersAt(const std::vector<double>& x) {
    const double length = std::exp(x[0]) * (1 + 0.2 * x[1] + 0.1 * x[1] * x[2]);
    return std::vector<double>{length, std::exp(-3 * x[0]) * (1 + 0.3 * x[2]),
                               1 + 0.4 * x[1] - 0.2 * std::sin(x[2])};
}

}  // namespace

TEST_CASE("a search meets targets that there is a solution for") {
    const std::vector<double> solution{0.7, 0.8, -0.6};
    const auto wanted = *numbersAt(solution);
    KnobSearch search(threeKnobs(), {{wanted[0], 1, 1}, {wanted[1], 1, -3}, {wanted[2], 1, 0}},
                      numbersAt);
    REQUIRE(search.begin({0, 0, 0}));
    search.takeDifferences();
    search.search(12, 1e-3);
    CHECK(search.worst(search.best()) < 1e-3);
    for (std::size_t k = 0; k < 3; ++k)
        CHECK(search.best().knobs[k] == Approx(solution[k]).margin(0.02));
}

TEST_CASE("a search stays near what is usual where targets leave it open") {
    auto knobs = threeKnobs();
    knobs[2].usual = 0.5;
    knobs[2].width = 0.1;
    KnobSearch search(knobs, {{1.3, 1, 1}}, [](const std::vector<double>& x) {
        return std::optional(std::vector<double>{(*numbersAt(x))[0]});
    });
    REQUIRE(search.begin({0, 0, 0.5}));
    search.takeDifferences();
    search.search(8, 1e-3);
    CHECK(search.worst(search.best()) < 1e-3);
    CHECK(search.best().knobs[2] == Approx(0.5).margin(0.05));
}

TEST_CASE("a search goes to the limits of knobs and no farther") {
    // The last number is at most 1 + 0.8 + 0.2.
    KnobSearch search(threeKnobs(), {{5, 1, 0}, {1, 1, 1}}, [](const std::vector<double>& x) {
        const auto all = *numbersAt(x);
        return std::optional(std::vector<double>{all[2], all[0]});
    });
    REQUIRE(search.begin({0, 0, 0}));
    search.takeDifferences();
    search.search(20, 1e-3);
    for (const double x : {search.best().knobs[1], search.best().knobs[2]})
        CHECK(std::fabs(x) <= 2 + 1e-12);
    CHECK(search.best().values[0] > 1.9);
    CHECK(search.worstTarget(search.best()) == 0);
    const auto [low, high] = search.rangeOf(0, 12, 0.05);
    CHECK(low < 1);
    CHECK(high > 1.9);
    CHECK(high <= 2 + 1e-9);
    CHECK(search.best().values[0] > 1.9);  // stays
}

TEST_CASE("a search goes on until what is only approached is near enough") {
    std::vector<KnobTarget> targets{{1.3, 1, 1}, {1.5, 0.3, 0}};
    targets[1].isStrict = false;
    const auto measure = [](const std::vector<double>& x) {
        const auto all = *numbersAt(x);
        return std::optional(std::vector<double>{all[0], all[2]});
    };
    const auto errorAfter = [&](double slack) {
        targets[1].slack = slack;
        KnobSearch search(threeKnobs(), targets, measure);
        REQUIRE(search.begin({std::log(1.3), 0, 0}));
        search.takeDifferences();
        search.search(20, 0.1);
        CHECK(search.isNear(search.best(), 0.1));
        return std::fabs(search.best().errors[1]);
    };
    CHECK(errorAfter(1) > 0.1);  // met at once
    CHECK(errorAfter(0.02) <= 0.02);
}

TEST_CASE("a search takes shorter steps where there is nothing to measure") {
    int nothing = 0;
    KnobSearch search(threeKnobs(), {{1.5, 1, 0}}, [&](const std::vector<double>& x) {
        if (x[1] > 0.9) {
            ++nothing;
            return std::optional<std::vector<double>>();
        }
        return std::optional(std::vector<double>{1 + x[1] * x[1] * x[1] + 0.01 * x[1]});
    });
    REQUIRE(search.begin({0, 0.3, 0}));
    CHECK_FALSE(search.begin({0, 1, 0}));
    search.takeDifferences();
    search.search(30, 1e-2);
    CHECK(nothing > 0);
    CHECK(search.worst(search.best()) < 1e-2);
}
