#include "vdbpack/core/parallel.h"

#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace vdbpack;

TEST_CASE("a work that throws leaves no other half done", "[core]") {
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
