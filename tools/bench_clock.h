// Time as measured by benchmarks.
#pragma once

#include <chrono>
#include <ctime>

/// Seconds on a monotonic clock.
inline double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Seconds that `work` takes.
template <class Work>
double secondsOf(const Work& work) {
    const double start = now();
    work();
    return now() - start;
}

/// Seconds of processor that all threads of the program take for `work`.
template <class Work>
double processorSecondsOf(const Work& work) {
    const std::clock_t start = std::clock();
    work();
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}
