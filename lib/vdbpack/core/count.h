// Counts that are indexed in 32 bits, and lists sorted by counting.
#pragma once

#include "vdbpack/core/error.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The count in 32 bits, the largest number of which is kept for "none".
/// @param things  what is counted, for the message; @param remedy  what to do instead.
/// @throws ResourceError from 2^32 - 1 on.
inline std::uint32_t indexable(std::uint64_t count, const std::string& things,
                               const std::string& remedy) {
    constexpr std::uint64_t kMost = 0xfffffffe;
    if (count > kMost)
        throw ResourceError(std::to_string(count) + ' ' + things + " are more than " +
                            std::to_string(kMost) + ", which can be numbered at once; " + remedy);
    return static_cast<std::uint32_t>(count);
}

/// Turns the number of entries in each cell into the position of its first one: `start` gets those
/// of all cells and the end of the last, `next` the same positions, to be raised as cells fill.
/// @return the number of all entries. @throws ResourceError from 2^32 - 1 on.
inline std::uint32_t firstPositions(std::vector<std::atomic<std::uint32_t>>& next,
                                    std::vector<std::uint32_t>& start, const std::string& things,
                                    const std::string& remedy) {
    start.resize(next.size() + 1);
    std::uint64_t sum = 0;
    for (std::size_t c = 0; c < next.size(); ++c) {
        start[c] = static_cast<std::uint32_t>(sum);
        sum += next[c].load(std::memory_order_relaxed);
        next[c].store(start[c], std::memory_order_relaxed);
    }
    return start.back() = indexable(sum, things, remedy);
}

/// Entries in the cell of an entry, on average. @param start  as of `firstPositions`
inline double crowding(const std::vector<std::uint32_t>& start) {
    double squares = 0;
    for (std::size_t c = 0; c + 1 < start.size(); ++c) {
        const double n = start[c + 1] - start[c];
        squares += n * n;
    }
    return start.empty() || start.back() == 0 ? 0 : squares / start.back();
}

}  // namespace vdbpack
