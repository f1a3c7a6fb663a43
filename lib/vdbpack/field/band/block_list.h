// Private: a list that grows without a copy of what it holds.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace vdbpack {

/// Items in blocks, each at a position of its own; positions where a block is not full are empty.
/// Threads can each fill a list of their own, which are then joined without a copy.
template <class T>
class BlockList {
public:
    static constexpr std::size_t kBlock = std::size_t{1} << 14;

    void add(const T& item) {
        if (blocks_.empty() || blocks_.back().size() == kBlock) {
            blocks_.emplace_back();
            blocks_.back().reserve(kBlock);
        }
        blocks_.back().push_back(item);
    }
    /// Takes the blocks of another list.
    void append(BlockList&& other) {
        for (auto& block : other.blocks_) blocks_.push_back(std::move(block));
        other.blocks_.clear();
    }

    /// One more than the last position.
    std::size_t end() const { return blocks_.size() * kBlock; }
    bool holds(std::size_t position) const {
        return position % kBlock < blocks_[position / kBlock].size();
    }
    const T& operator[](std::size_t position) const {
        return blocks_[position / kBlock][position % kBlock];
    }

    std::size_t blockCount() const { return blocks_.size(); }
    /// Visits the items of a block and frees it.
    template <class Visit>
    void consume(std::size_t block, const Visit& visit) {
        for (const T& item : blocks_[block]) visit(item);
        std::vector<T>().swap(blocks_[block]);
    }

private:
    std::vector<std::vector<T>> blocks_;
};

}  // namespace vdbpack
