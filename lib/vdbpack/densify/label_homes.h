// Private to densify: which rank keeps the sphere of a label.
#pragma once

#include "vdbpack/core/ranks.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdbpack {

/// Moves values to their places.
template <class T>
void sortByPlace(const std::vector<std::uint32_t>& places, std::vector<T>& values) {
    const std::vector<T> before = values;
    for (std::size_t i = 0; i < values.size(); ++i) values[places[i]] = before[i];
}

/// Spheres are relaxed where they are, and kept by the rank that placed them: their homes. Those
/// that are added are shared out in equal parts.
class LabelHomes {
public:
    /// @param labels  of this rank. @param pieces  as in DensifyOptions.
    LabelHomes(Ranks& ranks, const std::vector<std::uint32_t>& labels,
               std::vector<std::int64_t> pieces);

    /// Adds labels after the last one. @return the first
    std::uint32_t add(std::size_t count);
    int of(std::uint32_t label) const;
    const std::vector<std::int64_t>& pieces() const { return pieces_; }

    /// The position of a label among rising ones.
    static std::size_t indexOf(const std::vector<std::uint32_t>& labels, std::uint32_t label);

    /// Sends values to the homes of labels. @return those that came here
    template <class T, class LabelOf>
    std::vector<T> delivered(Ranks& ranks, const std::vector<T>& values,
                             const LabelOf& labelOf) const {
        std::vector<std::vector<T>> lists(static_cast<std::size_t>(ranks.count()));
        for (const T& value : values)
            lists[static_cast<std::size_t>(of(labelOf(value)))].push_back(value);
        return joined(exchanged(ranks, std::move(lists)));
    }

    /// Looks values up at the homes of `wanted`.
    /// @param labels, values  of this rank.
    std::vector<std::uint32_t> valuesAt(Ranks& ranks, const std::vector<std::uint32_t>& wanted,
                                        const std::vector<std::uint32_t>& labels,
                                        const std::vector<std::uint32_t>& values) const;

    /// Moves values to their places, which are labels of any rank.
    /// @param labels  of this rank, of its values in the end.
    template <class T>
    void sort(Ranks& ranks, const std::vector<std::uint32_t>& labels,
              const std::vector<std::uint32_t>& places, std::vector<T>& values) const {
        struct Placed {
            std::uint32_t place;
            T value;
        };
        std::vector<Placed> all;
        for (std::size_t i = 0; i < places.size(); ++i) all.push_back({places[i], values[i]});
        all = delivered(ranks, all, [](const Placed& placed) { return placed.place; });
        for (const Placed& placed : all) values[indexOf(labels, placed.place)] = placed.value;
    }

private:
    std::vector<std::int64_t> pieces_;
    std::vector<int> owners_;  // of the pieces
    int ranks_;
};

}  // namespace vdbpack
