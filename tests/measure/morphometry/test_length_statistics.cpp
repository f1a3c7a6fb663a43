// Distributions of thickness: quantiles, and their Kolmogorov-Smirnov distance.
#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/morphometry/phase_tally.h"

namespace {

/// With the quantiles `q(p)`, p from 0 to 1.
LengthStatistics distribution(const std::function<double(double)>& q) {
    LengthStatistics s;
    for (int i = 0; i <= 100; ++i) s.quantiles.push_back(q(0.01 * i));
    return s;
}

/// Share below `x`, by halving.
double shareBelow(const LengthStatistics& s, double x) {
    double low = 0, high = 100;
    if (x <= s.quantiles.front()) return 0;
    if (x > s.quantiles.back()) return 1;
    while (high - low > 1e-9) {
        const double p = 0.5 * (low + high);
        const auto i = std::min(static_cast<std::size_t>(p), std::size_t{99});
        const double t = p - static_cast<double>(i);
        // Equal ones stay equal so.
        const double q = s.quantiles[i] + t * (s.quantiles[i + 1] - s.quantiles[i]);
        (q < x ? low : high) = p;
    }
    return high / 100;
}

}  // namespace

TEST_CASE("quantiles are those of the sorted voxels") {
    const auto threads = GENERATE(1, 7);
    RandomStream random(4, 4);
    auto image = voxelImage(24, 0.5, [](const Vec<3>& x) { return x[0]; });
    std::vector<float> thickness;
    std::vector<double> solid;
    for (std::size_t i = 0; i < image.voxels(); ++i) {
        thickness.push_back(static_cast<float>(2 + 9 * std::pow(random.uniform(), 3)));
        if (image.distance[i] < 0) solid.push_back(0.5 * static_cast<double>(thickness[i]));
    }
    std::sort(solid.begin(), solid.end());
    const auto tallies = withThreads(threads, [&] { return tallyPhases(image, thickness); });
    const auto s = tallies.at(1).solid.statistics(0.5).value();
    REQUIRE(s.quantiles.size() == 101);
    REQUIRE(std::is_sorted(s.quantiles.begin(), s.quantiles.end()));
    REQUIRE(s.quantiles.front() == solid.front());
    REQUIRE(s.quantiles.back() == solid.back());
    REQUIRE(s.max == solid.back());
    for (std::size_t p = 1; p < 100; ++p)
        REQUIRE(s.quantiles[p] == Approx(solid[p * solid.size() / 100]).margin(0.5 / 32));
    REQUIRE(s.quantile(25) == s.quantiles[25]);
}

TEST_CASE("walls of two widths have their quantiles") {
    // 8 and 16 voxels wide, so that a third of the voxels is in the thin ones.
    const auto image = voxelImage(
        96, 0.1,
        [](const Vec<3>& x) {
            const double s = 10 * x[0];
            return 0.1 * std::min(std::abs(s + 18.3) - 4, std::abs(s - 14.2) - 8);
        },
        10);
    const auto s = measureMorphometry(image).thickness.value();
    REQUIRE(s.quantile(5) == within(0.8, 0.01));
    REQUIRE(s.quantile(25) == within(0.8, 0.01));
    REQUIRE(s.quantile(50) == within(1.6, 0.01));
    REQUIRE(s.quantile(95) == within(1.6, 0.01));
    REQUIRE(s.quantile(100) == s.max);
    REQUIRE(ksDistance(s, distribution([](double) { return 1.2; })) ==
            Approx(2.0 / 3).margin(0.01));
}

TEST_CASE("distributions have their Kolmogorov-Smirnov distance") {
    const auto even = distribution([](double p) { return p; });
    REQUIRE(ksDistance(even, even) == 0);
    REQUIRE(ksDistance(even, distribution([](double p) { return p + 0.3; })) == Approx(0.3));
    REQUIRE(ksDistance(even, distribution([](double p) { return p + 3; })) == 1);
    REQUIRE(ksDistance(even, distribution([](double p) { return 2 * p; })) == Approx(0.5));
    // Steps: all voxels alike, and a part of them.
    const auto one = distribution([](double) { return 0.25; });
    REQUIRE(ksDistance(one, one) == 0);
    REQUIRE(ksDistance(one, distribution([](double) { return 0.2500001; })) == 1);
    REQUIRE(ksDistance(one, even) == Approx(0.75));
    const auto part = distribution([](double p) { return std::max(p, 0.6); });
    REQUIRE(ksDistance(part, even) == Approx(0.6));
    REQUIRE_THROWS_AS(ksDistance(even, LengthStatistics{}), ParameterError);
}

TEST_CASE("the distance of distributions is the largest difference anywhere") {
    const auto seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    RandomStream random(seed, 6);
    const auto any = [&] {
        std::vector<double> q;
        for (int i = 0; i <= 100; ++i)
            q.push_back(i > 0 && random.uniform() < 0.2 ? q.back() : random.uniform());
        std::sort(q.begin(), q.end());
        LengthStatistics s;
        s.quantiles = q;
        return s;
    };
    const auto a = any(), b = any();
    double largest = 0;
    for (const auto& s : {a, b})
        for (const double q : s.quantiles)
            for (const double x : {q, q + 1e-9})
                largest = std::max(largest, std::abs(shareBelow(a, x) - shareBelow(b, x)));
    REQUIRE(ksDistance(a, b) == Approx(largest).margin(1e-5));
    REQUIRE(ksDistance(b, a) == ksDistance(a, b));
}
