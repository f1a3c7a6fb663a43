// Large arrays of the program lie on huge pages where the system grants them: a page fault for each
// 4 KiB took up to a fifth of a run.
#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;

}  // namespace

void* operator new(std::size_t bytes) {
    const bool isLarge = bytes >= kHugePage && bytes <= std::size_t{1} << 62;
    const std::size_t whole = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    void* const place =
        isLarge ? std::aligned_alloc(kHugePage, whole) : std::malloc(bytes > 0 ? bytes : 1);
    if (place == nullptr) throw std::bad_alloc();
    // It is a hint: where the system has no such pages, nothing changes.
    if (isLarge) madvise(place, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
    return place;
}

void operator delete(void* place) noexcept {
    std::free(place);
}

void operator delete(void* place, std::size_t) noexcept {
    std::free(place);
}
