// Large arrays of the program lie on huge pages where the system grants them: a page fault for each
// 4 KiB took up to a fifth of a run. Those that are given back are kept for the next ones, since
// the system clears pages before it hands them out: a tenth of a run with millions of triangles.
#include <malloc.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>

namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Blocks of whole huge pages that are in use no longer.
class KeptBlocks {
public:
    /// A block of at least so many bytes, and at most half as many more; null: none is kept. Then
    /// as much is given back as is about to be taken, so that both together never need more.
    void* take(std::size_t bytes) {
        const std::lock_guard<std::mutex> lock(mutex_);
        Block* best = nullptr;
        for (Block& block : blocks_)
            if (block.bytes >= bytes && block.bytes <= bytes + bytes / 2 &&
                (best == nullptr || block.bytes < best->bytes))
                best = &block;
        if (best != nullptr) return release(*best).at;
        for (std::size_t given = 0; given < bytes && total_ > 0;) {
            const Block largest = release(
                *std::max_element(blocks_.begin(), blocks_.end(),
                                  [](const auto& a, const auto& b) { return a.bytes < b.bytes; }));
            given += largest.bytes;
            std::free(largest.at);
        }
        return nullptr;
    }
    /// @return false if there is no room.
    bool keep(void* at, std::size_t bytes) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (bytes > kMostBytes - total_) return false;
        for (Block& block : blocks_) {
            if (block.at != nullptr) continue;
            block = {at, bytes};
            total_ += bytes;
            return true;
        }
        return false;
    }

private:
    struct Block {
        void* at = nullptr;
        std::size_t bytes = 0;
    };
    Block release(Block& block) {
        const Block released = block;
        block = {};
        total_ -= released.bytes;
        return released;
    }

    static constexpr std::size_t kMostBytes = std::size_t{1} << 30;
    std::array<Block, 64> blocks_{};
    std::size_t total_ = 0;
    std::mutex mutex_;
};

KeptBlocks keptBlocks;  // before and after all that allocates: it has no constructor to run

}  // namespace

void* operator new(std::size_t bytes) {
    const bool isLarge = bytes >= kHugePage && bytes <= std::size_t{1} << 62;
    const std::size_t whole = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    if (isLarge)
        if (void* const kept = keptBlocks.take(whole)) return kept;
    void* const place =
        isLarge ? std::aligned_alloc(kHugePage, whole) : std::malloc(bytes > 0 ? bytes : 1);
    if (place == nullptr) throw std::bad_alloc();
    // It is a hint: where the system has no such pages, nothing changes.
    if (isLarge) madvise(place, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
    return place;
}

void operator delete(void* place) noexcept {
    if (place != nullptr && reinterpret_cast<std::uintptr_t>(place) % kHugePage == 0) {
        const std::size_t whole = malloc_usable_size(place) / kHugePage * kHugePage;
        if (whole > 0 && keptBlocks.keep(place, whole)) return;
    }
    std::free(place);
}

void operator delete(void* place, std::size_t) noexcept {
    operator delete(place);
}
