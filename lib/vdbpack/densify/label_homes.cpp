#include "vdbpack/densify/label_homes.h"

#include <algorithm>

namespace vdbpack {

LabelHomes::LabelHomes(Ranks& ranks, const std::vector<std::uint32_t>& labels,
                       std::vector<std::int64_t> pieces)
    : pieces_(std::move(pieces)), ranks_(ranks.count()) {
    std::vector<std::uint64_t> owners(pieces_.size());
    std::size_t piece = 0;
    for (const std::uint32_t label : labels) {
        while (piece + 1 < pieces_.size() && pieces_[piece + 1] <= std::int64_t{label}) ++piece;
        owners[piece] = static_cast<std::uint64_t>(ranks.rank()) + 1;
    }
    ranks.sum(owners);
    for (const std::uint64_t owner : owners) owners_.push_back(static_cast<int>(owner) - 1);
}

std::uint32_t LabelHomes::add(std::size_t count) {
    const std::int64_t first = pieces_.back();
    pieces_.pop_back();
    owners_.resize(pieces_.size());
    for (int r = 0; r <= ranks_; ++r) {
        const auto share = static_cast<std::size_t>(r) * count / static_cast<std::size_t>(ranks_);
        pieces_.push_back(first + static_cast<std::int64_t>(share));
        owners_.push_back(r < ranks_ ? r : -1);
    }
    return static_cast<std::uint32_t>(first);
}

int LabelHomes::of(std::uint32_t label) const {
    // Of pieces that begin at one label, all but the last are empty.
    const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), std::int64_t{label});
    return owners_[static_cast<std::size_t>(next - pieces_.begin()) - 1];
}

std::size_t LabelHomes::indexOf(const std::vector<std::uint32_t>& labels, std::uint32_t label) {
    return static_cast<std::size_t>(std::lower_bound(labels.begin(), labels.end(), label) -
                                    labels.begin());
}

std::vector<std::uint32_t> LabelHomes::valuesAt(Ranks& ranks,
                                                const std::vector<std::uint32_t>& wanted,
                                                const std::vector<std::uint32_t>& labels,
                                                const std::vector<std::uint32_t>& values) const {
    const auto count = static_cast<std::size_t>(ranks.count());
    std::vector<std::vector<std::uint32_t>> asked(count);
    std::vector<std::vector<std::size_t>> askers(count);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const auto home = static_cast<std::size_t>(of(wanted[i]));
        asked[home].push_back(wanted[i]);
        askers[home].push_back(i);
    }
    auto answers = exchanged(ranks, std::move(asked));
    for (auto& list : answers)
        for (std::uint32_t& v : list) v = values[indexOf(labels, v)];
    answers = exchanged(ranks, std::move(answers));
    std::vector<std::uint32_t> all(wanted.size());
    for (std::size_t r = 0; r < count; ++r)
        for (std::size_t k = 0; k < answers[r].size(); ++k) all[askers[r][k]] = answers[r][k];
    return all;
}

}  // namespace vdbpack
