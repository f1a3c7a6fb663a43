// What the thread sanitizer reports of tasks: every race, and nothing else.

#include "vdbpack/core/parallel.h"

#include <catch2/catch.hpp>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_for_each.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_group.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace {

std::atomic<int> reports{0};

}  // namespace

// The sanitizer's own hooks. Races are wanted here: they must not make the program fail, and each
// counts, also where another lay at the same address.
extern "C" void __tsan_on_report(void*);
extern "C" void __tsan_on_report(void*) {
    ++reports;
}
extern "C" const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() {
    return "exitcode=0:suppress_equal_addresses=0:suppress_equal_stacks=0";
}

using namespace vdbpack;

namespace {

/// Holds the tasks that come until there are two of them, in two threads. It orders nothing: what
/// they write after it races.
class Meeting {
public:
    void wait() {
        arrived_.fetch_add(1, std::memory_order_relaxed);
        const auto start = std::chrono::steady_clock::now();
        while (arrived_.load(std::memory_order_relaxed) < 2) {
            if (std::chrono::steady_clock::now() - start > std::chrono::seconds(20))
                throw std::runtime_error("the other task does not come");
            std::this_thread::yield();
        }
    }

private:
    std::atomic<int> arrived_{0};
};

/// How many races the sanitizer reports of `work` on four threads.
template <class Work>
int reportsOf(Work work) {
    const int before = reports;
    withThreads(4, work);
    return reports - before;
}

constexpr int kTimes = 20;

}  // namespace

TEST_CASE("iterations that write one variable are reported", "[threads]") {
    Meeting meeting;
    int shared = 0;
    const auto apart = [&](int i) {
        meeting.wait();
        shared += i;
    };
    CHECK(reportsOf([&] { tbb::parallel_for(0, 2, apart); }) > 0);
}

TEST_CASE("branches of parallel_invoke that write one variable are reported", "[threads]") {
    Meeting meeting;
    int shared = 0;
    const auto one = [&] {
        meeting.wait();
        shared = 1;
    };
    const auto other = [&] {
        meeting.wait();
        shared = 2;
    };
    CHECK(reportsOf([&] { tbb::parallel_invoke(one, other); }) > 0);
}

TEST_CASE("a reduction that writes besides its sum is reported", "[threads]") {
    Meeting meeting;
    int largest = 0;
    const auto sum = [&](const tbb::blocked_range<int>& range, int before) {
        meeting.wait();
        largest = range.end();
        return before + static_cast<int>(range.size());
    };
    const auto reduce = [&] {
        return tbb::parallel_deterministic_reduce(tbb::blocked_range<int>(0, 2, 1), 0, sum,
                                                  std::plus<>());
    };
    CHECK(reportsOf(reduce) > 0);
}

TEST_CASE("a task that reads what its maker still writes is reported", "[threads]") {
    Meeting meeting;
    std::vector<int> values(1);
    int seen = 0;
    const auto work = [&] {
        tbb::task_group group;
        group.run([&] {
            meeting.wait();
            seen = values[0];
        });
        meeting.wait();
        values[0] = 1;
        group.wait();
    };
    CHECK(reportsOf(work) > 0);
}

TEST_CASE("a task that a task makes and nobody waits for in time is reported", "[threads]") {
    Meeting meeting;
    int shared = 0;
    const auto work = [&] {
        tbb::task_group group;
        group.run([&] {
            group.run([&] {
                meeting.wait();
                shared = 1;
            });
            meeting.wait();
            shared = 2;
        });
        group.wait();
    };
    CHECK(reportsOf(work) > 0);
}

TEST_CASE("loops whose iterations share nothing are not reported", "[threads]") {
    const auto work = [] {
        std::vector<int> values(100000);
        for (int n = 0; n < kTimes; ++n) {
            tbb::parallel_for(std::size_t{0}, values.size(), [&](std::size_t i) {
                values[i] = static_cast<int>((i * 7919) % 100003);
            });
            const auto add = [&](const tbb::blocked_range<std::size_t>& range, long sum) {
                for (auto i = range.begin(); i < range.end(); ++i) sum += values[i];
                return sum;
            };
            const tbb::blocked_range<std::size_t> all(0, values.size());
            const long sum = tbb::parallel_reduce(all, 0L, add, std::plus<>());
            if (sum != tbb::parallel_deterministic_reduce(all, 0L, add, std::plus<>()))
                throw std::logic_error("the sums differ");
            tbb::parallel_sort(values.begin(), values.end());
            tbb::parallel_invoke([&] { values[0] = 1; }, [&] { values[1] = 2; },
                                 [&] { values[2] = 3; });
            tbb::parallel_for_each(values.begin(), values.end(), [](int& value) { ++value; });
        }
    };
    CHECK(reportsOf(work) == 0);
}

TEST_CASE("loops in loops that work on memory of their own are not reported", "[threads]") {
    const auto work = [] {
        for (int n = 0; n < kTimes; ++n) {
            tbb::enumerable_thread_specific<std::vector<int>> found;
            tbb::parallel_for(0, 200, [&](int i) {
                std::vector<int> inner(100);
                tbb::parallel_for(0, 100,
                                  [&](int k) { inner[static_cast<std::size_t>(k)] = i + k; });
                found.local().push_back(std::accumulate(inner.begin(), inner.end(), 0));
            });
            std::size_t count = 0;
            for (const auto& mine : found) count += mine.size();
            if (count != 200) throw std::logic_error("some are lost");
        }
    };
    CHECK(reportsOf(work) == 0);
}

TEST_CASE("tasks that start when those before them are done are not reported", "[threads]") {
    // As blocks of a pack: the last of two tasks starts the third, which reads what both left.
    const auto work = [] {
        for (int n = 0; n < kTimes * 10; ++n) {
            tbb::task_group group;
            std::vector<std::vector<int>> left(3);
            std::atomic<int> waiting{2};
            const auto third = [&] { left[2].assign(1, left[0][0] + left[1][0]); };
            for (const std::size_t i : {0, 1})
                group.run([&, i] {
                    left[i].assign(100, 1);
                    if (--waiting == 0) group.run(third);
                });
            group.wait();
            if (left[2][0] != 2) throw std::logic_error("the third came too soon");
        }
    };
    CHECK(reportsOf(work) == 0);
}

TEST_CASE("an exception that leaves a task is not reported", "[threads]") {
    const auto work = [] {
        for (int n = 0; n < kTimes; ++n) {
            std::vector<int> done(1000);
            const auto fail = [&](std::size_t i) {
                done[i] = 1;
                if (i == 700) throw std::runtime_error("at 700");
            };
            try {
                tbb::parallel_for(std::size_t{0}, done.size(), fail);
            } catch (const std::runtime_error& e) {
                if (std::string(e.what()) != "at 700") throw;
                done.assign(1, 0);
            }
        }
    };
    CHECK(reportsOf(work) == 0);
}
