// Threads: how many a computation may use, loops over indices, a value for each thread.
#pragma once

#include "vdbpack/core/box.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

/// The number of threads for a request; 0: all cores.
inline int effectiveThreads(int threads) {
    return threads > 0 ? threads : tbb::info::default_concurrency();
}

/// Runs `work()` with `threads` threads, more than the machine has cores if asked; 0: all cores.
/// TBB algorithms inside use just these. @return what `work` returns; its exceptions pass through.
/// @param beside  further threads that an arena inside may have.
template <class Work>
auto withThreads(int threads, Work work, int beside = 0) {
    const int count = effectiveThreads(threads);
    // Without this, TBB never starts more workers than there are cores.
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(count + beside));
    tbb::task_arena arena(count);
    return arena.execute(work);
}

using IndexRange = tbb::blocked_range<std::size_t>;

/// tbb::parallel_for over a range, compiled once: `call(work, part)` for parts of the range.
void callForParts(const IndexRange& range, void (*call)(const void*, const IndexRange&),
                  const void* work);

/// Calls `work(part)` for parts of a range, as tbb::parallel_for does.
template <class Work>
void parallelFor(const IndexRange& range, const Work& work) {
    callForParts(
        range,
        [](const void* any, const IndexRange& part) { (*static_cast<const Work*>(any))(part); },
        &work);
}

/// Calls `work(i)` for first <= i < last, as tbb::parallel_for does.
template <class Index, class Work>
void parallelFor(Index first, Index last, const Work& work) {
    if (first < last)
        parallelFor(IndexRange(0, static_cast<std::size_t>(last - first)),
                    [&](const IndexRange& part) {
                        for (std::size_t i = part.begin(); i < part.end(); ++i)
                            work(static_cast<Index>(first + static_cast<Index>(i)));
                    });
}

/// Calls `work(i)` for 0 <= i < n, thousands in a task: for work of a few nanoseconds each.
template <class Work>
void forAll(std::size_t n, const Work& work) {
    constexpr std::size_t kGrain = 4096;
    parallelFor(IndexRange(0, n, kGrain), [&](const IndexRange& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) work(i);
    });
}

/// The untyped part of PerThread: pointers that `make` returns, one for each thread.
class ThreadSlots {
public:
    ThreadSlots(std::function<void*()> make, void (*destroy)(void*));
    ~ThreadSlots();
    void* local();
    const std::vector<void*>& all() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A value for each thread that asks for one: tbb::enumerable_thread_specific, of which most is
/// compiled once for all types. Values are visited in the order in which threads first asked.
template <class T>
class PerThread {
public:
    PerThread() : PerThread([] { return T(); }) {}
    /// @param make  returns the value with which a thread begins.
    template <class Make, class = std::enable_if_t<std::is_invocable_v<Make>>>
    explicit PerThread(Make make)
        : slots_([make = std::move(make)]() -> void* { return new T(make()); },
                 [](void* value) { delete static_cast<T*>(value); }) {}

    /// The value of the thread that calls.
    T& local() { return *static_cast<T*>(slots_.local()); }

    class Iterator {
    public:
        explicit Iterator(void* const* at) : at_(at) {}
        T& operator*() const { return *static_cast<T*>(*at_); }
        Iterator& operator++() { return ++at_, *this; }
        bool operator!=(const Iterator& other) const { return at_ != other.at_; }

    private:
        void* const* at_;
    };
    Iterator begin() { return Iterator(slots_.all().data()); }
    Iterator end() { return Iterator(slots_.all().data() + slots_.all().size()); }

private:
    ThreadSlots slots_;
};

/// Runs `works` beside one another, each to its end: in tbb::parallel_invoke an exception of one
/// ends TBB algorithms within the others early, which then go on with what is half done.
/// The exception of the first work that has one passes through.
template <class... Works>
void invokeAll(const Works&... works) {
    const std::array<std::function<void()>, sizeof...(works)> all{works...};
    std::array<std::exception_ptr, sizeof...(works)> thrown;
    parallelFor(std::size_t{0}, all.size(), [&](std::size_t i) {
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
