// A priority queue of numbered items whose order need only be nearly right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Items 0, 1, 2, ... by rising key, in buckets of a given width; within a bucket first in, first
/// out. Every operation takes a constant time, where a binary heap spends a seventh of the
/// packer's.
class BucketQueue {
public:
    /// Empties the queue. Keys below `lowest` share the first bucket.
    void reset(float lowest, float width);

    /// Puts `item` where `key` says; if it is queued already, moves it there.
    void push(std::uint32_t item, float key);
    /// Takes `item` out; does nothing if it is not queued.
    void remove(std::uint32_t item);
    /// Takes an item of the lowest key out. @return kNone if there is none.
    std::uint32_t pop();
    static constexpr std::uint32_t kNone = 0xffffffffu;

private:
    struct Link {
        std::uint32_t before = kNone, after = kNone;
        std::uint32_t bucket = kNone;  ///< kNone: not queued
    };
    struct Bucket {
        std::uint32_t first = kNone, last = kNone;
    };
    std::uint32_t bucketOf(float key) const;

    float lowest_ = 0, inverse_ = 1;
    std::vector<Link> links_;  ///< by item
    std::vector<Bucket> buckets_;
    std::vector<std::uint64_t> used_;  ///< a bit a bucket: it holds items
    std::size_t word_ = 0;             ///< no word of `used_` before this one has a bit set
};

}  // namespace vdbpack
