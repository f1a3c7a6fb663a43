// What the thread sanitizer cannot see of TBB, told to it.
//
// The packaged libtbb is not instrumented: that a task is spawned before it runs and ends before
// its wait returns goes unseen, and every pair of tasks looks like a race. The functions of
// libtbb through which all of its headers spawn, wait and allocate are therefore replaced here, in
// the executable, by ones that call the original and show just these edges. Nothing else is ordered
// by this file, so two tasks that may run at once still race. The ends of tasks need no more than
// the reference counts of TBB's headers, which are compiled, and thus instrumented, with our code.
#include <dlfcn.h>
#include <oneapi/tbb/detail/_small_object_pool.h>
#include <oneapi/tbb/detail/_task.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>
#include <oneapi/tbb/version.h>
#include <sanitizer/tsan_interface.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>

#if TBB_INTERFACE_VERSION_MAJOR != 12
#error "Another TBB: see which functions of libtbb its headers call now"
#endif

namespace {

using tbb::detail::d1::delegate_base;
using tbb::detail::d1::execution_data;
using tbb::detail::d1::slot_id;
using tbb::detail::d1::small_object_pool;
using tbb::detail::d1::task;
using tbb::detail::d1::task_arena_base;
using tbb::detail::d1::task_group_context;
using tbb::detail::d1::wait_context;

/// The function of libtbb that the one of the same mangled name here stands before.
template <class Function>
Function* original(const char* name) {
    void* const found = dlsym(RTLD_NEXT, name);
    if (found == nullptr) {
        std::fprintf(stderr, "tbb_edges: libtbb has no %s\n", name);
        std::abort();
    }
    return reinterpret_cast<Function*>(found);
}

/// Calls `last` at the end of a block, however it ends: the waits of TBB throw what a task threw.
template <class Last>
class AtEnd {
public:
    explicit AtEnd(Last last) : last_(last) {}
    AtEnd(const AtEnd&) = delete;
    ~AtEnd() { last_(); }

private:
    Last last_;
};

/// Stands for a task in libtbb's queues: what its spawner did comes before what it does.
class SpawnedTask final : public task {
public:
    explicit SpawnedTask(task& inner) : inner_(&inner) { __tsan_release(this); }

    // A task that it hands back runs next in the same thread and needs no edge.
    task* execute(execution_data& ed) override {
        __tsan_acquire(this);
        task* const next = inner_->execute(ed);  // where it throws, `cancel` is called after
        delete this;
        return next;
    }
    task* cancel(execution_data& ed) override {
        __tsan_acquire(this);
        task* const next = inner_->cancel(ed);
        delete this;
        return next;
    }

private:
    task* inner_;
};

/// Stands for what is to be done in an arena, maybe by another thread while this one waits.
class ArenaWork final : public delegate_base {
public:
    explicit ArenaWork(delegate_base& inner) : inner_(inner) { __tsan_release(&given_); }
    bool operator()() const override {
        __tsan_acquire(&given_);
        const AtEnd leave([this] { __tsan_release(&done_); });
        return inner_();
    }
    void enterAfter() const { __tsan_acquire(&done_); }

private:
    delegate_base& inner_;
    mutable char given_ = 0, done_ = 0;  // addresses of the edges
};

/// The last of a context's tasks sets the count of tasks to 0 as its last step: that it was read is
/// what libtbb's wait has done unseen. The count is the second of two words, private to TBB.
void enterAfter(wait_context& context) {
    static_assert(sizeof(wait_context) == 2 * sizeof(std::uint64_t));
    __tsan_acquire(reinterpret_cast<char*>(&context) + sizeof(std::uint64_t));
}

/// Memory for TBB by malloc, which the sanitizer knows; TBB's own pools hand it from thread to
/// thread unseen. What libtbb does with it in between is not instrumented: it only must not seem to
/// be given back before it was taken.
void* take(void* memory) {
    if (memory == nullptr) throw std::bad_alloc();
    __tsan_release(memory);
    return memory;
}
void* takeAligned(std::size_t bytes) {
    constexpr std::size_t kLine = 128;
    return take(std::aligned_alloc(kLine, (bytes + kLine - 1) / kLine * kLine));
}
void giveBack(void* memory) {
    if (memory == nullptr) return;
    __tsan_acquire(memory);
    std::free(memory);
}

small_object_pool* noPool() {
    alignas(small_object_pool) static char place[sizeof(small_object_pool)];
    return reinterpret_cast<small_object_pool*>(place);
}

}  // namespace

namespace tbb::detail::r1 {

void spawn(d1::task& t, d1::task_group_context& context) {
    static auto* const real = original<void(task&, task_group_context&)>(
        "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextE");
    real(*new SpawnedTask(t), context);
}

void spawn(d1::task& t, d1::task_group_context& context, d1::slot_id slot) {
    static auto* const real = original<void(task&, task_group_context&, slot_id)>(
        "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextEt");
    real(*new SpawnedTask(t), context, slot);
}

void submit(d1::task& t, d1::task_group_context& context, arena* where, std::uintptr_t critical) {
    static auto* const real = original<void(task&, task_group_context&, arena*, std::uintptr_t)>(
        "_ZN3tbb6detail2r16submitERNS0_2d14taskERNS2_18task_group_contextEPNS1_5arenaEm");
    real(*new SpawnedTask(t), context, where, critical);
}

void enqueue(d1::task& t, d1::task_arena_base* where) {
    static auto* const real = original<void(task&, task_arena_base*)>(
        "_ZN3tbb6detail2r17enqueueERNS0_2d14taskEPNS2_15task_arena_baseE");
    real(*new SpawnedTask(t), where);
}

void enqueue(d1::task& t, d1::task_group_context& context, d1::task_arena_base* where) {
    static auto* const real = original<void(task&, task_group_context&, task_arena_base*)>(
        "_ZN3tbb6detail2r17enqueueERNS0_2d14taskERNS2_18task_group_contextEPNS2_15task_arena_"
        "baseE");
    real(*new SpawnedTask(t), context, where);
}

void execute(d1::task_arena_base& where, d1::delegate_base& work) {
    static auto* const real = original<void(task_arena_base&, delegate_base&)>(
        "_ZN3tbb6detail2r17executeERNS0_2d115task_arena_baseERNS2_13delegate_baseE");
    ArenaWork seen(work);
    const AtEnd enter([&] { seen.enterAfter(); });
    real(where, seen);
}

void wait(d1::wait_context& context, d1::task_group_context& group) {
    static auto* const real = original<void(wait_context&, task_group_context&)>(
        "_ZN3tbb6detail2r14waitERNS0_2d112wait_contextERNS2_18task_group_contextE");
    const AtEnd enter([&] { enterAfter(context); });
    real(context, group);
}

// The first task runs in the calling thread.
void execute_and_wait(d1::task& t, d1::task_group_context& tasks, d1::wait_context& context,
                      d1::task_group_context& group) {
    static auto* const real = original<void(task&, task_group_context&, wait_context&,
                                            task_group_context&)>(
        "_ZN3tbb6detail2r116execute_and_waitERNS0_2d14taskERNS2_18task_group_contextERNS2_12wait_"
        "contextES6_");
    const AtEnd enter([&] { enterAfter(context); });
    real(t, tasks, context, group);
}

// Machines with one or two processors run too little at once for races to show.
int numa_default_concurrency(int node) {
    static auto* const real = original<int(int)>("_ZN3tbb6detail2r124numa_default_concurrencyEi");
    return std::max(4, real(node));
}

void* allocate(d1::small_object_pool*& pool, std::size_t bytes) {
    pool = noPool();
    return takeAligned(bytes);
}
void* allocate(d1::small_object_pool*& pool, std::size_t bytes, const d1::execution_data&) {
    return allocate(pool, bytes);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t) {
    giveBack(memory);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t, const d1::execution_data&) {
    giveBack(memory);
}

void* cache_aligned_allocate(std::size_t bytes) {
    return takeAligned(bytes);
}
void cache_aligned_deallocate(void* memory) {
    giveBack(memory);
}

void* allocate_memory(std::size_t bytes) {
    return take(std::malloc(bytes));
}
void deallocate_memory(void* memory) {
    giveBack(memory);
}

}  // namespace tbb::detail::r1
