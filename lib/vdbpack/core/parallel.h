// Threads: how many a computation may use, and the plainest use of them.
#pragma once

#include "vdbpack/core/box.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <functional>

namespace vdbpack {

/// Runs `work()` with `threads` threads, more than the machine has cores if asked; 0: all cores.
/// TBB algorithms inside use just these. @return what `work` returns; its exceptions pass through.
/// @param beside  further threads that an arena inside may have.
template <class Work>
auto withThreads(int threads, Work work, int beside = 0) {
    const int count = threads > 0 ? threads : tbb::info::default_concurrency();
    // Without this, TBB never starts more workers than there are cores.
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(count + beside));
    tbb::task_arena arena(count);
    return arena.execute(work);
}

/// Calls `work(i)` for 0 <= i < n, thousands in a task: for work of a few nanoseconds each.
template <class Work>
void forAll(std::size_t n, const Work& work) {
    constexpr std::size_t kGrain = 4096;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, kGrain),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          for (std::size_t i = part.begin(); i < part.end(); ++i) work(i);
                      });
}

/// Runs `works` beside one another, each to its end: in tbb::parallel_invoke an exception of one
/// ends TBB algorithms within the others early, which then go on with what is half done.
/// The exception of the first work that has one passes through.
template <class... Works>
void invokeAll(const Works&... works) {
    const std::array<std::function<void()>, sizeof...(works)> all{works...};
    std::array<std::exception_ptr, sizeof...(works)> thrown;
    tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
        try {
            all[i]();
        } catch (...) {
            thrown[i] = std::current_exception();
        }
    });
    for (const std::exception_ptr& exception : thrown)
        if (exception) std::rethrow_exception(exception);
}

/// The bounds of all that `add(i, box)` adds, 0 <= i < n.
template <int Dim, class Add>
Box<Dim> boundsOfAll(std::size_t n, const Add& add) {
    constexpr std::size_t kGrain = 4096;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, n, kGrain), Box<Dim>{},
        [&](const tbb::blocked_range<std::size_t>& part, Box<Dim> box) {
            for (std::size_t i = part.begin(); i < part.end(); ++i) add(i, box);
            return box;
        },
        [](Box<Dim> one, const Box<Dim>& other) {
            for (int i = 0; i < Dim; ++i) {
                one.lo[i] = std::min(one.lo[i], other.lo[i]);
                one.hi[i] = std::max(one.hi[i], other.hi[i]);
            }
            return one;
        });
}

}  // namespace vdbpack
