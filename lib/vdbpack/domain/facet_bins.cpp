#include "vdbpack/domain/facet_bins.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

// More empty rings than this are not counted; a search starts there at the latest.
constexpr std::uint8_t kMostRings = 7;
constexpr std::size_t kFacetsPerChunk = 4096;
/// Ranges of cells that are filled in parallel.
constexpr std::size_t kSlabs = 64;
// Facets in the cell of a common entry from which a tree is faster; bones have about 5.
constexpr double kCrowded = 256;
// A triangle lower than this share of its longest edge is replaced by that edge: its normal has no
// digits left, and its points move by less than this share.
constexpr double kSliver = 1e-8;

void simplifySliver(Facet<2>&) {}

void simplifySliver(Facet<3>& f) {
    int longest = 0;
    double square = 0;
    for (int i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double s = squaredLength(f[(k + 1) % 3] - f[k]);
        if (s > square) {
            square = s;
            longest = i;
        }
    }
    if (squaredLength(facetNormal(f)) > kSliver * kSliver * square * square) return;
    const auto k = static_cast<std::size_t>(longest);
    f = {f[k], f[(k + 1) % 3], f[(k + 1) % 3]};
}

/// Median over (a sample of) the facets of the longest side of their bounds, mm.
template <int Dim>
double commonExtent(const std::vector<Facet<Dim>>& facets) {
    std::vector<double> extents;
    const std::size_t stride = facets.size() / 4096 + 1;
    for (std::size_t i = 0; i < facets.size(); i += stride) {
        const Vec<Dim> size = facetBox(facets[i]).size();
        extents.push_back(*std::max_element(size.c.begin(), size.c.end()));
    }
    const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
    std::nth_element(extents.begin(), middle, extents.end());
    return *middle;
}

/// Entries of some facets, by slabs of cells; in each slab with rising facets.
class Chunk {
public:
    std::vector<FacetEntry> entries;

    /// Sorts the entries by slabs of `cellsPerSlab` cells.
    void sortBySlab(std::size_t slabs, std::size_t cellsPerSlab) {
        start_.assign(slabs + 1, 0);
        for (const auto& entry : entries) ++start_[entry.cell / cellsPerSlab + 1];
        for (std::size_t s = 0; s < slabs; ++s) start_[s + 1] += start_[s];
        std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
        std::vector<FacetEntry> sorted(entries.size());
        for (const auto& entry : entries) sorted[next[entry.cell / cellsPerSlab]++] = entry;
        entries = std::move(sorted);
    }
    const FacetEntry* first(std::size_t slab) const { return entries.data() + start_[slab]; }
    const FacetEntry* last(std::size_t slab) const { return entries.data() + start_[slab + 1]; }

private:
    std::vector<std::size_t> start_;  // of each slab, and one past the last
};

/// Entries of all facets in chunks of rising facets. @return false if there are more than `most`.
template <int Dim>
bool listAll(const FacetCells<Dim>& cells, const std::vector<Facet<Dim>>& facets, std::size_t most,
             std::vector<Chunk>& chunks) {
    chunks.resize((facets.size() + kFacetsPerChunk - 1) / kFacetsPerChunk);
    std::atomic<std::size_t> total{0};
    parallelFor(IndexRange(0, chunks.size(), 1), [&](const IndexRange& range) {
        for (std::size_t k = range.begin(); k != range.end(); ++k) {
            auto& entries = chunks[k].entries;
            const std::size_t begin = k * kFacetsPerChunk;
            const std::size_t end = std::min(facets.size(), begin + kFacetsPerChunk);
            std::size_t counted = 0;
            for (std::size_t i = begin; i < end && total <= most; ++i) {
                listCells(cells, facets[i], static_cast<std::uint32_t>(i), most, entries);
                total += entries.size() - counted;
                counted = entries.size();
            }
        }
    });
    return total <= most;
}

}  // namespace

template <int Dim>
FacetBins<Dim>::FacetBins(std::vector<Facet<Dim>> facets) : facets_(std::move(facets)) {
    cells_.bounds = boundsOfAll<Dim>(facets_.size(), [&](std::size_t i, Box<Dim>& box) {
        for (const auto& corner : facets_[i]) box.add(corner);
    });
    forAll(facets_.size(), [&](std::size_t i) { simplifySliver(facets_[i]); });
    if (facets_.empty()) return;
    origin_ = cells_.bounds.center();
    // Cells as large as a common facet: a question then meets few cells and few facets in each.
    cells_.setEdge(commonExtent(facets_), facets_.size());
    while (!fill(24 * facets_.size() + 65536)) cells_.setEdge(1.5 * cells_.edge, facets_.size());
    if constexpr (Dim == 3)
        if (crowding(start_) > kCrowded) {
            std::vector<std::uint32_t>().swap(start_);
            std::vector<Item>().swap(items_);
            tree_ = TriangleTree(facets_.size(), [&](std::size_t i) { return facets_[i]; });
            return;
        }
    rings_ = emptyRings(cells_, start_, kMostRings);
}

/// Sorts the facets into the cells that they meet. @return false if that takes more than
/// `mostItems` entries.
template <int Dim>
bool FacetBins<Dim>::fill(std::size_t mostItems) {
    std::vector<Chunk> chunks;
    if (!listAll(cells_, facets_, mostItems, chunks)) return false;
    // A counting sort, slab by slab: facets stay in their order within each cell, for any number of
    // threads.
    const std::size_t cells = cells_.size(), perSlab = cells / kSlabs + 1;
    parallelFor(std::size_t{0}, chunks.size(),
                [&](std::size_t k) { chunks[k].sortBySlab(kSlabs, perSlab); });
    std::array<std::size_t, kSlabs + 1> slabStart{};
    for (const auto& chunk : chunks)
        for (std::size_t s = 0; s < kSlabs; ++s)
            slabStart[s + 1] += static_cast<std::size_t>(chunk.last(s) - chunk.first(s));
    for (std::size_t s = 0; s < kSlabs; ++s) slabStart[s + 1] += slabStart[s];
    const std::vector<Item> ballOf = balls();
    items_.resize(slabStart[kSlabs]);
    start_.assign(cells + 1, static_cast<std::uint32_t>(slabStart[kSlabs]));
    parallelFor(std::size_t{0}, kSlabs, [&](std::size_t s) {
        const std::size_t begin = std::min(s * perSlab, cells),
                          end = std::min(begin + perSlab, cells);
        std::fill(start_.data() + begin, start_.data() + end, 0);
        for (const auto& chunk : chunks)
            for (const auto* entry = chunk.first(s); entry != chunk.last(s); ++entry)
                ++start_[entry->cell];
        auto sum = static_cast<std::uint32_t>(slabStart[s]);
        for (std::size_t cell = begin; cell < end; ++cell) sum = start_[cell] += sum;
        // From the last entry to the first: what was the end of a cell becomes its start.
        for (std::size_t k = chunks.size(); k-- > 0;)
            for (const auto* entry = chunks[k].last(s); entry != chunks[k].first(s);) {
                --entry;
                items_[--start_[entry->cell]] = ballOf[entry->facet];
            }
    });
    return true;
}

/// One item per facet.
template <int Dim>
std::vector<typename FacetBins<Dim>::Item> FacetBins<Dim>::balls() const {
    // Rounding of a local coordinate to float, on both sides of a comparison.
    const double rounding = 3e-7 * length(cells_.bounds.size());
    std::vector<Item> balls(facets_.size());
    forAll(facets_.size(), [&](std::size_t i) {
        const Vec<Dim> center = facetBox(facets_[i]).center();
        double square = 0;
        for (const auto& corner : facets_[i])
            square = std::max(square, squaredLength(corner - center));
        for (int k = 0; k < Dim; ++k)
            balls[i].center[static_cast<std::size_t>(k)] =
                static_cast<float>(center[k] - origin_[k]);
        balls[i].radius = static_cast<float>(std::sqrt(square) * (1 + 1e-6) + rounding);
        balls[i].facet = static_cast<std::uint32_t>(i);
    });
    return balls;
}

template <int Dim>
std::size_t FacetBins<Dim>::memoryBytes() const {
    return facets_.capacity() * sizeof(Facet<Dim>) + start_.capacity() * sizeof(std::uint32_t) +
           items_.capacity() * sizeof(Item) + rings_.capacity() + tree_.memoryBytes();
}

template class FacetBins<2>;
template class FacetBins<3>;

}  // namespace vdbpack
