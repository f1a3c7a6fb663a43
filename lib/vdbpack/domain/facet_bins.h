// Exact queries, with a bounded reach, of the distance to facets.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/facet.h"
#include "vdbpack/domain/facet_cells.h"
#include "vdbpack/mesh/triangle_tree.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Facets binned into cubic cells, for queries with a bounded reach. The facets need not be
/// connected, closed or oriented.
///
/// Every cell also stores a lower bound of the number of cells to the nearest facet, so that a
/// query far from all facets takes one lookup. Results are exact to rounding and the
/// same for any number of threads. Thread-safe.
///
/// Where long triangles crowd the cells, as in a fan of thousands around one corner, a tree takes
/// their place.
///
/// Memory: about 200 bytes per triangle of a bone; cells and entries are limited in proportion to
/// the facets, for facets of any sizes.
template <int Dim>
class FacetBins {
public:
    /// @param facets  finite corners; facets without area are taken as segments or points.
    /// Cost: linear in the facets, in parallel; about 0.5 µs per facet of a bone.
    explicit FacetBins(std::vector<Facet<Dim>> facets);

    /// The nearest point of all facets, if closer to `x` than `reach`.
    /// @return false, `wall` untouched, if there is none.
    bool nearest(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) const;

    /// Appends the nearest point of every facet that is closer to `x` than `reach`; some may be
    /// repeated.
    void within(const Vec<Dim>& x, double reach, std::vector<WallPoint<Dim>>& points) const;

    /// Whether any facet is closer to `x` than `reach`.
    bool anyCloser(const Vec<Dim>& x, double reach) const;

    const std::vector<Facet<Dim>>& facets() const { return facets_; }
    const Box<Dim>& bounds() const { return cells_.bounds; }
    std::size_t memoryBytes() const;

private:
    /// A facet listed in a cell, with a ball around it (relative to `origin_`, rounded outward)
    /// that shows most facets to be too far without reading their corners.
    struct Item {
        std::array<float, static_cast<std::size_t>(Dim)> center;
        float radius;
        std::uint32_t facet;
    };

    enum class Want { kAny, kNearest, kAll };
    template <Want kWant, class Found>
    class Search;

    bool fill(std::size_t mostItems);
    template <Want kWant, class Found>
    bool searchTree(const Vec<Dim>& x, double reach, Found* found) const;
    std::vector<Item> balls() const;

    std::vector<Facet<Dim>> facets_;
    FacetCells<Dim> cells_;
    Vec<Dim> origin_;
    std::vector<std::uint32_t> start_;  // first item of each cell, and one past the last
    std::vector<Item> items_;           // facets by cell
    std::vector<std::uint8_t> rings_;   // of each cell, as `emptyRings`
    TriangleTree tree_;                 // instead of the cells; in space only
};

}  // namespace vdbpack
