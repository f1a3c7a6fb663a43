// Private to densify: bodies that are tested as neighbors, eight at a time.
#pragma once

#include "vdbpack/densify/body.h"

#include <cstdint>
#include <cstring>
#include <vector>

namespace vdbpack {

/// Bodies component by component.
struct Candidates {
    std::vector<std::uint32_t> x, y, z, slots;
    std::vector<std::uint32_t> found;  ///< scratch space for all slots and eight more
    std::vector<float> radii, margins;
    std::vector<std::uint32_t> listed, ends;  ///< neighbors of all slots, and where each's end
    std::size_t count = 0;

    /// Appends `all[first]` to `all[last - 1]`, and their margins; whole eights are read.
    void add(const Body* all, const Body* homes, std::uint32_t first, std::uint32_t last) {
        if (const std::size_t n = count + (last - first) + 8; n > slots.size())
            for (auto* list : {&x, &y, &z, &slots, &found}) list->resize(2 * n + 8);
        radii.resize(slots.size());
        margins.resize(slots.size());
        for (std::uint32_t j = first; j < last; j += 8) {
            const Bodies8 b = load(all + j);
            const std::size_t to = count + (j - first);
            store(x.data() + to, b.x);
            store(y.data() + to, b.y);
            store(z.data() + to, b.z);
            store(radii.data() + to, b.radius);
            store(margins.data() + to, load(homes + j).radius);
            store(slots.data() + to, Word8{0, 1, 2, 3, 4, 5, 6, 7} + j);
        }
        count += last - first;
    }
    Float8 marginsAt(std::size_t at) const { return load(margins.data() + at); }
    Word8 numbers(std::size_t at) const {
        Word8 numbers;
        std::memcpy(&numbers, slots.data() + at, sizeof numbers);
        return numbers;
    }
    Bodies8 bodies(std::size_t at) const {
        Bodies8 b;
        std::memcpy(&b.x, x.data() + at, sizeof b.x);
        std::memcpy(&b.y, y.data() + at, sizeof b.y);
        std::memcpy(&b.z, z.data() + at, sizeof b.z);
        std::memcpy(&b.radius, radii.data() + at, sizeof b.radius);
        return b;
    }
};

}  // namespace vdbpack
