// Private to runs: which rows of the pack of all ranks one rank has.
#pragma once

#include "vdbpack/core/ranks.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Spheres of a rank that are rows of the pack of all ranks one after another.
struct RowSpan {
    std::size_t begin = 0, end = 0;  ///< spheres of this rank
    std::size_t piece = 0;           ///< among the pieces of all ranks, from 0
    std::uint64_t row = 0;           ///< of the first sphere
};

/// The rows of this rank's spheres in the pack of all: existing ones first, then in the order of
/// the front. Called by all ranks.
/// @param order   of the spheres of this rank, of which the first `fixed` existed.
/// @param pieces  as in PackResult.
std::vector<RowSpan> rowSpans(Ranks& ranks, const std::vector<std::int64_t>& order,
                              std::size_t fixed, const std::vector<std::int64_t>& pieces);

/// Where the pieces of all ranks begin that the spans of this rank belong to, if they follow one
/// another. Called by all ranks.
/// @param sizes   of the piece of each span. @param pieces  number of all, at least.
/// @return a value for each span, and their sum over all.
std::vector<std::uint64_t> startsOfPieces(Ranks& ranks, const std::vector<RowSpan>& spans,
                                          const std::vector<std::uint64_t>& sizes,
                                          std::size_t pieces);

}  // namespace vdbpack
