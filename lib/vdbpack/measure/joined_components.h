// Connected components of a pack from those of its parts.
#pragma once

#include "vdbpack/core/ranks.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Joins the components that the parts of a pack were found to have: where two parts know one
/// sphere, its component here and its component there are one.
///
/// Other ranks hear of no components but those that reach into other parts.
class JoinedComponents {
public:
    explicit JoinedComponents(Ranks& ranks) : ranks_(ranks) {}

    /// Adds a part, whose own spheres are the first.
    /// @param component  of each sphere, as in `PartContacts`.
    /// @param rows       a number of each, the same in each part that knows it.
    /// @param shared     1 for each that several parts know.
    void add(std::size_t own, const std::vector<std::uint32_t>& component,
             const std::vector<std::int64_t>& rows, const std::vector<std::uint8_t>& shared);

    struct Result {
        std::uint64_t components = 0;
        std::uint64_t largest = 0;  ///< spheres of the largest
    };
    /// Called by all ranks.
    Result join();

private:
    /// A component of a part, and a sphere in it or the number of its own spheres.
    struct Entry {
        std::uint64_t label, number;
    };
    std::vector<Entry> links();

    Ranks& ranks_;
    std::uint64_t parts_ = 0;
    std::vector<Entry> known_;  // of spheres that several parts know
    std::vector<Entry> sizes_;  // of their components
    Result alone_;              // of components within one part
};

}  // namespace vdbpack
