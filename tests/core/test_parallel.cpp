#include "support/test.h"

#include "vdbpack/core/parallel.h"

#include <atomic>
#include <chrono>
#include <thread>

TEST_CASE("a work that throws leaves no other half done") {
    std::atomic<bool> thrown{false};
    std::vector<int> done(100000);
    const auto run = [&] {
        invokeAll(
            [&] {
                thrown = true;
                throw std::runtime_error("first");
            },
            [&] {
                while (!thrown) std::this_thread::yield();
                std::this_thread::sleep_for(std::chrono::milliseconds(20));
                forAll(done.size(), [&](std::size_t i) { done[i] = 1; });
                throw std::runtime_error("second");
            });
    };
    CHECK_THROWS_WITH(withThreads(2, run), "first");
    CHECK(done == std::vector<int>(done.size(), 1));
}

TEST_CASE("each thread has a value of its own, and loops reach every index once") {
    std::vector<int> visits(100000);
    PerThread<std::vector<std::size_t>> mine([] { return std::vector<std::size_t>{7}; });
    withThreads(4, [&] {
        parallelFor(std::size_t{0}, visits.size(), [&](std::size_t i) {
            ++visits[i];
            mine.local().push_back(i);
        });
        return 0;
    });
    CHECK(visits == std::vector<int>(visits.size(), 1));
    std::size_t count = 0;
    for (const auto& each : mine) {
        CHECK(each.front() == 7);
        count += each.size() - 1;
    }
    CHECK(count == visits.size());
    parallelFor(5, 5, [&](int) { FAIL("an empty loop"); });
}
