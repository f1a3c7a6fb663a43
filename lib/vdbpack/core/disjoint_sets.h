// Disjoint sets (union-find).
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace vdbpack {

/// Members 0 to n - 1, each in a set of its own until sets are joined; the smallest member of a set
/// represents it. Not thread-safe.
/// Source: union-find with path halving (Tarjan, van Leeuwen 1984, doi:10.1145/62.2160).
class DisjointSets {
public:
    explicit DisjointSets(std::size_t n = 0) : parent_(n) {
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }
    /// A further member, in a set of its own.
    std::uint32_t add() {
        parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
        return parent_.back();
    }
    std::size_t size() const { return parent_.size(); }
    /// The representative of the set of `i`.
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// Joins the sets of `i` and `j`.
    void join(std::uint32_t i, std::uint32_t j) {
        i = find(i);
        j = find(j);
        if (j < i) std::swap(i, j);
        parent_[j] = i;
    }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace vdbpack
