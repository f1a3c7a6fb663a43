// Time as measured by benchmarks.
#pragma once

#include <chrono>

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
