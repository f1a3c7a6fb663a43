// Private to verify: sorting into slots by counting.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// From the number of entries of each slot to the first position of each, and the end.
/// @param counts  become the first positions too: the next free one of each slot.
inline std::vector<std::uint32_t> startsOf(std::vector<std::atomic<std::uint32_t>>& counts) {
    std::vector<std::uint32_t> start(counts.size() + 1);
    std::uint32_t sum = 0;
    for (std::size_t s = 0; s < counts.size(); ++s) {
        start[s] = sum;
        sum += counts[s].load(std::memory_order_relaxed);
        counts[s].store(start[s], std::memory_order_relaxed);
    }
    start.back() = sum;
    return start;
}

}  // namespace vdbpack
