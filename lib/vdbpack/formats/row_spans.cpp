#include "vdbpack/formats/row_spans.h"

namespace vdbpack {

std::vector<std::uint64_t> startsOfPieces(Ranks& ranks, const std::vector<RowSpan>& spans,
                                          const std::vector<std::uint64_t>& sizes,
                                          std::size_t pieces) {
    std::vector<std::uint64_t> all(pieces);
    for (std::size_t s = 0; s < spans.size(); ++s) all[spans[s].piece] = sizes[s];
    ranks.sum(all);
    std::vector<std::uint64_t> starts;
    std::uint64_t sum = 0;
    std::size_t span = 0;
    for (std::size_t p = 0; p < pieces; ++p) {
        if (span < spans.size() && spans[span].piece == p) {
            starts.push_back(sum);
            ++span;
        }
        sum += all[p];
    }
    starts.push_back(sum);
    return starts;
}

std::vector<RowSpan> rowSpans(Ranks& ranks, const std::vector<std::int64_t>& order,
                              std::size_t fixed, const std::vector<std::int64_t>& pieces) {
    std::vector<RowSpan> spans;
    if (fixed > 0) spans.push_back({0, fixed, 0, 0});
    std::size_t at = fixed;
    for (std::size_t p = 1; p < pieces.size(); ++p) {
        const std::size_t begin = at;
        while (at < order.size() && order[at] < pieces[p]) ++at;
        if (at > begin) spans.push_back({begin, at, p, 0});
    }
    std::vector<std::uint64_t> sizes;
    for (const RowSpan& span : spans) sizes.push_back(span.end - span.begin);
    const auto starts = startsOfPieces(ranks, spans, sizes, pieces.size() + 1);
    for (std::size_t s = 0; s < spans.size(); ++s) spans[s].row = starts[s];
    return spans;
}

}  // namespace vdbpack
