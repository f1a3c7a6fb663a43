#include "vdbpack/pack/front/bucket_queue.h"

#include <algorithm>

namespace vdbpack {

namespace {
/// More buckets than any block needs; keys above the last share it.
constexpr float kMostBuckets = 1 << 24;
}  // namespace

void BucketQueue::reset(float lowest, float width) {
    lowest_ = lowest;
    inverse_ = 1 / width;
    links_.clear();
    buckets_.clear();
    used_.clear();
    word_ = 0;
}

std::uint32_t BucketQueue::bucketOf(float key) const {
    const float at = (key - lowest_) * inverse_;
    return at > 0 ? static_cast<std::uint32_t>(std::min(at, kMostBuckets)) : 0;
}

void BucketQueue::push(std::uint32_t item, float key) {
    const std::uint32_t b = bucketOf(key);
    if (item >= links_.size()) links_.resize(std::size_t{item} + 1);
    Link& link = links_[item];
    if (link.bucket == b) return;
    remove(item);
    if (b >= buckets_.size()) {
        used_.resize(std::max<std::size_t>(b / 64 + 1, 2 * used_.size()), 0);
        buckets_.resize(64 * used_.size());
    }
    Bucket& bucket = buckets_[b];
    link = {bucket.last, kNone, b};
    (bucket.last == kNone ? bucket.first : links_[bucket.last].after) = item;
    bucket.last = item;
    used_[b / 64] |= std::uint64_t{1} << (b % 64);
    word_ = std::min<std::size_t>(word_, b / 64);
}

void BucketQueue::remove(std::uint32_t item) {
    if (item >= links_.size() || links_[item].bucket == kNone) return;
    const Link link = links_[item];
    Bucket& bucket = buckets_[link.bucket];
    (link.before == kNone ? bucket.first : links_[link.before].after) = link.after;
    (link.after == kNone ? bucket.last : links_[link.after].before) = link.before;
    if (bucket.first == kNone) used_[link.bucket / 64] &= ~(std::uint64_t{1} << (link.bucket % 64));
    links_[item].bucket = kNone;
}

std::uint32_t BucketQueue::pop() {
    while (word_ < used_.size() && used_[word_] == 0) ++word_;
    if (word_ == used_.size()) return kNone;
    const auto bit = static_cast<std::size_t>(__builtin_ctzll(used_[word_]));
    const std::uint32_t item = buckets_[64 * word_ + bit].first;
    remove(item);
    return item;
}

}  // namespace vdbpack
