// Exact, bounded questions about the distance to a soup of triangles (2D: segments).
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/domain.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A piece of wall: the corners of a triangle (2D: the ends of a segment), mm.
template <int Dim>
using Facet = std::array<Vec<Dim>, static_cast<std::size_t>(Dim)>;

/// Facets binned into cubic cells, for questions with a bounded reach.
///
/// Every cell also knows how many cells away the nearest facet is at least, so that a question
/// far from all facets is answered by one lookup. Answers are exact to rounding and the same for
/// any number of threads. Thread-safe.
///
/// Memory: about 200 bytes a triangle of a bone; cells and entries are limited in proportion to
/// the facets, however unequal these are.
template <int Dim>
class FacetBins {
public:
    /// @param facets  finite corners; facets without area are taken as segments or points.
    /// Cost: linear in the facets, in parallel; about 0.5 µs a facet of a bone.
    explicit FacetBins(std::vector<Facet<Dim>> facets);

    /// The nearest point of all facets, if closer to `x` than `reach`.
    /// @return false, `wall` untouched, if there is none.
    bool nearest(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) const;

    /// Adds the nearest point of every facet that is closer to `x` than `reach`; some may come
    /// more than once.
    void within(const Vec<Dim>& x, double reach, std::vector<WallPoint<Dim>>& points) const;

    /// Whether any facet is closer to `x` than `reach`.
    bool anyCloser(const Vec<Dim>& x, double reach) const;

    const std::vector<Facet<Dim>>& facets() const { return facets_; }
    const Box<Dim>& bounds() const { return bounds_; }
    double cellSize() const { return cell_; }
    std::size_t memoryBytes() const;

private:
    using Index = std::array<int, static_cast<std::size_t>(Dim)>;

    /// A facet listed in a cell, with a ball around it (relative to `origin_`, rounded outward)
    /// that tells most facets to be too far without a look at their corners.
    struct Item {
        std::array<float, static_cast<std::size_t>(Dim)> center;
        float radius;
        std::uint32_t facet;
    };

    enum class Want { kAny, kNearest, kAll };

    /// @param found  the nearest point, or the vector that all are added to.
    template <Want kWant, class Found>
    bool search(const Vec<Dim>& x, double reach, Found* found) const;
    void chooseCell(double cell);
    bool fill(std::size_t mostItems);
    void markDistances();

    std::vector<Facet<Dim>> facets_;
    Box<Dim> bounds_;
    Vec<Dim> origin_;
    double cell_ = 1;                   // edge of a cell, mm
    double inverse_ = 1;                // 1 / cell_
    Index count_{};                     // cells along each axis
    std::vector<std::uint32_t> start_;  // first item of each cell, and one past the last
    std::vector<Item> items_;           // facets by cell
    std::vector<std::uint8_t> rings_;   // rings of cells around a cell known to be empty
};

extern template class FacetBins<2>;
extern template class FacetBins<3>;

}  // namespace vdbpack
