// Damaged files.
#pragma once

#include "vdbpack/core/rng.h"

#include <string>

namespace vdbpack::test {

/// `content`, not empty, with a random bit inverted `flips` times.
inline std::string withFlippedBits(std::string content, int flips, RandomStream& random) {
    for (int k = 0; k < flips; ++k)
        content[random.bits() % content.size()] ^= static_cast<char>(1 << (random.bits() % 8));
    return content;
}

}  // namespace vdbpack::test
