// Vertices with identical coordinates made one.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace vdbpack {

/// Gives each distinct point one index, in the order of the first occurrence. -0 equals 0.
///
/// Open addressing with linear probing, half full at most. A small table of recent points in front
/// of it answers most queries without a cache miss, since the triangles of a file are mostly next
/// to those before them.
class Welder {
public:
    /// @param expected  about how many distinct points there will be, to reserve their memory.
    explicit Welder(std::size_t expected = 0);

    /// Index of the point, whose coordinates must be finite.
    std::uint32_t add(const Vec<3>& point) {
        const std::uint64_t h = hash(point);
        std::uint32_t& recent = recent_[h % kRecent];
        if (recent < vertices_.size() && vertices_[recent] == point) return recent;
        return recent = find(point, h);
    }
    std::size_t size() const { return vertices_.size(); }
    std::vector<Vec<3>> takeVertices() { return std::move(vertices_); }

private:
    static constexpr std::size_t kRecent = 8192;
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    static std::uint64_t hash(const Vec<3>& point) {
        std::uint64_t h = 0;
        for (const double x : point.c) {
            const double noSign = x + 0.0;  // -0 becomes 0
            std::uint64_t bits = 0;
            std::memcpy(&bits, &noSign, sizeof bits);
            h = mix64(h ^ bits) + 0x9e3779b97f4a7c15ull;
        }
        return h;
    }
    struct Slot {
        std::uint32_t index = kNone;
        std::uint32_t hash = 0;  ///< the lower half: tells most other points without their vertex
    };
    std::uint32_t find(const Vec<3>& point, std::uint64_t h);
    void resize(std::size_t slots);

    std::vector<Vec<3>> vertices_;
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> recent_ = std::vector<std::uint32_t>(kRecent, kNone);
};

}  // namespace vdbpack
