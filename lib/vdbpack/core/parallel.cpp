#include "vdbpack/core/parallel.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <mutex>

namespace vdbpack {

void callForParts(const IndexRange& range, void (*call)(const void*, const IndexRange&),
                  const void* work) {
    tbb::parallel_for(range, [call, work](const IndexRange& part) { call(work, part); });
}

struct ThreadSlots::Impl {
    std::function<void*()> make;
    void (*destroy)(void*);
    tbb::enumerable_thread_specific<void*> locals{nullptr};
    std::mutex mutex;
    std::vector<void*> all;
};

ThreadSlots::ThreadSlots(std::function<void*()> make, void (*destroy)(void*)) : impl_(new Impl) {
    impl_->make = std::move(make);
    impl_->destroy = destroy;
}

ThreadSlots::~ThreadSlots() {
    for (void* value : impl_->all) impl_->destroy(value);
}

void* ThreadSlots::local() {
    void*& mine = impl_->locals.local();
    if (mine == nullptr) {
        void* made = impl_->make();
        const std::lock_guard<std::mutex> lock(impl_->mutex);
        impl_->all.push_back(made);
        mine = made;
    }
    return mine;
}

const std::vector<void*>& ThreadSlots::all() const {
    return impl_->all;
}

}  // namespace vdbpack
