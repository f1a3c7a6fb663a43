#include "support/sizes.h"
#include "support/test.h"

#include "vdbpack/pack/radius_pool.h"

TEST_CASE("what a pool hands out follows the distribution, whatever is taken") {
    const auto sizes = SizeDistribution::parse("uniform:1,2", 3);
    const auto seed = GENERATE(range(1u, 6u));
    // Always the largest, always the smallest, or alternating: the pool must not drift.
    const int habit = GENERATE(0, 1, 2);
    CAPTURE(seed, habit);
    RadiusPool pool(sizes, seed, 7, 64);
    pool.refill();
    std::vector<double> taken;
    for (int i = 0; i < 20000; ++i) {
        const bool large = habit == 0 || (habit == 2 && i % 2 == 0);
        const std::size_t k = large ? pool.size() - 1 : 0;
        taken.push_back(pool[k]);
        pool.take(k);
        REQUIRE(std::is_sorted(&taken[0], &taken[0]));
    }
    // All that is missing are the radii still pending.
    CHECK(ksOf(taken, sizes) < (static_cast<double>(pool.size()) + 20) / 20000);
}

TEST_CASE("a pool is full and sorted, and has a radius up to the mean when it is asked to") {
    const auto sizes = SizeDistribution::parse("lognormal:1,0.5,0.3,3", 3);
    RadiusPool pool(sizes, 3, 1, 16);
    pool.refill();
    for (int i = 0; i < 1000; ++i) {
        REQUIRE(pool.size() >= 16);
        if (i % 10 == 0) {
            pool.refill();
            REQUIRE(pool.smallest() <= sizes.mean());
        }
        for (std::size_t k = 1; k < pool.size(); ++k) REQUIRE(pool[k - 1] <= pool[k]);
        REQUIRE(pool.countUpTo(pool.largest()) == pool.size());
        REQUIRE(pool.countUpTo(pool.smallest() * 0.5) == 0);
        pool.take(0);
    }
}

TEST_CASE("a pool notices that large radii leave it") {
    const auto sizes = SizeDistribution::parse("uniform:1,2", 3);
    RadiusPool pool(sizes, 1, 1, 64);
    pool.refill();
    CHECK_FALSE(pool.hasGivenLarge());
    for (int i = 0; i < 20; ++i) pool.take(pool.size() - 1);
    CHECK(pool.hasGivenLarge());
    // What is drawn past the pending ones has the mean of the distribution; what comes back does
    // not count.
    for (int i = 0; i < 2000; ++i) {
        const double drawn = pool.draw();
        if (i % 2 == 0) pool.giveBack(drawn), pool.take(pool.countUpTo(drawn) - 1);
    }
    CHECK_FALSE(pool.hasGivenLarge());
}
