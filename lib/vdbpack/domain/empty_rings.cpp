// How far every cell is from the nearest cell with a facet.
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/facet_cells.h"

namespace vdbpack {

namespace {

/// Calls `work(row)` for all rows in parallel.
template <class Work>
void forRows(std::size_t rows, const Work& work) {
    parallelFor(IndexRange(0, rows, 256), [&](const IndexRange& range) {
        for (std::size_t row = range.begin(); row != range.end(); ++row) work(row);
    });
}

/// Marks (1) of cells, spread to neighboring cells one axis after the other.
template <int Dim>
class RingMarks {
public:
    explicit RingMarks(const typename FacetCells<Dim>::Index& count, std::size_t cells)
        : marked(cells),
          count_(count),
          across_(static_cast<std::size_t>(count[0])),
          rows_(cells / across_),
          next_(cells) {}

    /// Marks the neighbors of marked cells, diagonal ones too.
    void grow() {
        growWithinRows();
        std::size_t step = 1;  // rows between neighbors along the axis
        for (int axis = 1; axis < Dim; ++axis) {
            const auto n = static_cast<std::size_t>(count_[static_cast<std::size_t>(axis)]);
            growAcrossRows(step, n);
            step *= n;
        }
    }

    std::vector<std::uint8_t> marked;

private:
    void growWithinRows() {
        forRows(rows_, [&](std::size_t row) {
            const std::uint8_t* from = marked.data() + row * across_;
            std::uint8_t* to = next_.data() + row * across_;
            for (std::size_t i = 0; i < across_; ++i) to[i] = from[i];
            for (std::size_t i = 1; i < across_; ++i)
                to[i] = static_cast<std::uint8_t>(to[i] | from[i - 1]);
            for (std::size_t i = 0; i + 1 < across_; ++i)
                to[i] = static_cast<std::uint8_t>(to[i] | from[i + 1]);
        });
        marked.swap(next_);
    }

    /// @param step  rows between neighbors along the axis. @param n  cells along it.
    void growAcrossRows(std::size_t step, std::size_t n) {
        forRows(rows_, [&](std::size_t row) {
            const std::size_t at = row / step % n;
            const std::uint8_t* from = marked.data() + row * across_;
            const std::uint8_t* below = at > 0 ? from - step * across_ : from;
            const std::uint8_t* above = at + 1 < n ? from + step * across_ : from;
            std::uint8_t* to = next_.data() + row * across_;
            for (std::size_t i = 0; i < across_; ++i)
                to[i] = static_cast<std::uint8_t>(from[i] | below[i] | above[i]);
        });
        marked.swap(next_);
    }

    const typename FacetCells<Dim>::Index& count_;
    std::size_t across_, rows_;
    std::vector<std::uint8_t> next_;
};

}  // namespace

template <int Dim>
std::vector<std::uint8_t> emptyRings(const FacetCells<Dim>& cells,
                                     const std::vector<std::uint32_t>& start, std::uint8_t most) {
    const std::size_t n = cells.size();
    std::vector<std::uint8_t> rings(n);
    RingMarks<Dim> near(cells.count, n);
    forAll(n, [&](std::size_t i) { near.marked[i] = start[i] != start[i + 1]; });
    for (std::uint8_t ring = 0; ring < most; ++ring) {
        if (ring > 0) near.grow();
        forAll(n, [&](std::size_t i) {
            rings[i] = static_cast<std::uint8_t>(rings[i] + (near.marked[i] == 0));
        });
    }
    return rings;
}

template std::vector<std::uint8_t> emptyRings(const FacetCells<2>&,
                                              const std::vector<std::uint32_t>&, std::uint8_t);
template std::vector<std::uint8_t> emptyRings(const FacetCells<3>&,
                                              const std::vector<std::uint32_t>&, std::uint8_t);

}  // namespace vdbpack
