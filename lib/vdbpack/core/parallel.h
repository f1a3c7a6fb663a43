// Threads: how many a computation may use.
#pragma once

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace vdbpack {

/// Runs `work()` with `threads` threads, more than the machine has cores if asked; 0: all cores.
/// TBB algorithms inside use just these. @return what `work` returns; its exceptions pass through.
template <class Work>
auto withThreads(int threads, Work work) {
    const int count = threads > 0 ? threads : tbb::info::default_concurrency();
    // Without this, TBB never starts more workers than there are cores.
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(count));
    tbb::task_arena arena(count);
    return arena.execute(work);
}

}  // namespace vdbpack
