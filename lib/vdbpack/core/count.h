// Counts that are indexed in 32 bits.
#pragma once

#include "vdbpack/core/error.h"

#include <cstdint>
#include <string>

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

}  // namespace vdbpack
