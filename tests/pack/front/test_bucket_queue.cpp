#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/pack/front/bucket_queue.h"

TEST_CASE("the bucket queue pops by rising bucket, first in first out") {
    // Against a list that is searched: pushes, moves, removals and pops at random.
    constexpr float kLowest = -3, kWidth = 0.25f;
    BucketQueue queue;
    for (const std::uint64_t seed : {1, 2, 3}) {
        queue.reset(kLowest, kWidth);
        RandomStream random(seed, 0);
        std::vector<std::pair<int, std::uint32_t>> oracle;  // bucket and item, as pushed
        const auto indexOf = [&](std::uint32_t item) {
            std::size_t i = 0;
            while (i < oracle.size() && oracle[i].second != item) ++i;
            return i;
        };
        for (int step = 0; step < 4000; ++step) {
            const auto item = static_cast<std::uint32_t>(random.uniform() * 300);
            const double action = random.uniform();
            const std::size_t at = indexOf(item);
            if (action < 0.6) {
                const auto key = static_cast<float>(random.uniform() * 60 - 5);
                const int bucket =
                    std::max(0, static_cast<int>(std::floor((key - kLowest) / kWidth)));
                queue.push(item, key);
                if (at < oracle.size() && oracle[at].first == bucket) continue;  // stays
                if (at < oracle.size())
                    oracle.erase(oracle.begin() + static_cast<std::ptrdiff_t>(at));
                oracle.emplace_back(bucket, item);
            } else if (action < 0.75) {
                queue.remove(item);
                if (at < oracle.size())
                    oracle.erase(oracle.begin() + static_cast<std::ptrdiff_t>(at));
            } else {
                const std::uint32_t popped = queue.pop();
                if (oracle.empty()) {
                    REQUIRE(popped == BucketQueue::kNone);
                    continue;
                }
                const auto lowest = std::min_element(
                    oracle.begin(), oracle.end(),
                    [](const auto& a, const auto& b) { return a.first < b.first; });
                REQUIRE(popped == lowest->second);
                oracle.erase(lowest);
            }
        }
    }
}
