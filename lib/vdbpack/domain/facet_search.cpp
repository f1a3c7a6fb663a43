// The search through rings of cells that answers the questions of FacetBins.
#include "vdbpack/domain/facet_bins.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

/// One question: cells are visited ring by ring outward from the cell of `x`, until no facet
/// beyond can be closer than the best so far.
///
/// All steps are inlined into `run`, so that the state of a search stays in registers.
template <int Dim>
template <typename FacetBins<Dim>::Want kWant, class Found>
class FacetBins<Dim>::Search {
public:
    /// @param found  the nearest point, or the vector that all are appended to.
    [[gnu::always_inline]] Search(const FacetBins& bins, const Vec<Dim>& x, double reach,
                                  Found* found)
        : bins_(bins), x_(x), reach_(reach), found_(found) {}

    [[gnu::always_inline]] bool run() {
        if (!(reach_ > 0) || bins_.facets_.empty() || !locate()) return false;
        begin();
        for (; ring_ <= lastRing_; ++ring_) {
            if (ring_ > 0) {
                const double bound = (ring_ - 1) * bins_.cells_.edge + margin_;
                if (bound > 0 && bound * bound >= best_) break;
            }
            if (visitRing()) return true;
        }
        if constexpr (kWant == Want::kNearest)
            if (any_) found_->distance = std::sqrt(best_);
        return any_;
    }

private:
    // Facets that were looked at last, by the low bits of their numbers.
    static constexpr std::size_t kAsked = 32;

    /// Finds the home cell of `x` and the rings to visit. @return false where no facet can be
    /// within reach.
    [[gnu::always_inline]] bool locate() {
        const FacetCells<Dim>& cells = bins_.cells_;
        margin_ = cells.edge;
        bool onGrid = true;
        for (int i = 0; i < Dim; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const double from = x_[i] - cells.bounds.lo[i];
            if (!(from > -reach_ && x_[i] - cells.bounds.hi[i] < reach_)) return false;
            // Points far outside take the outermost index that still is a number of cells.
            const double index = std::clamp(std::floor(from * cells.inverse), -1e9,
                                            static_cast<double>(cells.count[k]) + 1e9);
            home_[k] = static_cast<int>(index);
            within_[i] = from - index * cells.edge;
            margin_ = std::min({margin_, within_[i], cells.edge - within_[i]});
            const int beyond = std::max({0, -home_[k], home_[k] - (cells.count[k] - 1)});
            onGrid = onGrid && beyond == 0;
            ring_ = std::max(ring_, beyond);
            lastRing_ = std::max({lastRing_, home_[k], cells.count[k] - 1 - home_[k]});
        }
        for (int i = 1; i < Dim; ++i)
            stride_[i] = stride_[i - 1] *
                         static_cast<std::size_t>(cells.count[static_cast<std::size_t>(i - 1)]);
        if (onGrid) {
            std::size_t cell = 0;
            for (int i = 0; i < Dim; ++i)
                cell += stride_[i] * static_cast<std::size_t>(home_[static_cast<std::size_t>(i)]);
            ring_ = bins_.rings_[cell];
        }
        // Rounding of the home cell is far below this share of a cell.
        margin_ -= 1e-7 * cells.edge;
        return true;
    }

    [[gnu::always_inline]] void begin() {
        asked_.fill(std::numeric_limits<std::uint32_t>::max());
        best_ = reach_ * reach_;
        bestLength_ = static_cast<float>(reach_ * (1 + 1e-6));
        for (int i = 0; i < Dim; ++i)
            local_[static_cast<std::size_t>(i)] = static_cast<float>(x_[i] - bins_.origin_[i]);
    }

    /// Squared distance of `x` to the cells at `offset` from home along an axis.
    [[gnu::always_inline]] double axisSquare(int axis, int offset) const {
        if (offset == 0) return 0.0;
        const double edge = bins_.cells_.edge;
        double d = offset > 0 ? offset * edge - within_[axis] : within_[axis] - (offset + 1) * edge;
        d -= 1e-7 * edge;
        return d > 0 ? d * d : 0.0;
    }

    /// @return as all below: true once the answer is known.
    [[gnu::always_inline]] bool visitRing() {
        const auto& count = bins_.cells_.count;
        const int fromY = std::max(-ring_, -home_[1]);
        const int toY = std::min(ring_, count[1] - 1 - home_[1]);
        if constexpr (Dim == 2) {
            for (int y = fromY; y <= toY; ++y)
                if (visitRow(stride_[1] * static_cast<std::size_t>(home_[1] + y), axisSquare(1, y),
                             std::abs(y) == ring_))
                    return true;
        } else {
            const int fromZ = std::max(-ring_, -home_[2]);
            const int toZ = std::min(ring_, count[2] - 1 - home_[2]);
            for (int z = fromZ; z <= toZ; ++z) {
                const double squareZ = axisSquare(2, z);
                if (squareZ >= best_) continue;
                const std::size_t plane = stride_[2] * static_cast<std::size_t>(home_[2] + z);
                for (int y = fromY; y <= toY; ++y)
                    if (visitRow(plane + stride_[1] * static_cast<std::size_t>(home_[1] + y),
                                 squareZ + axisSquare(1, y),
                                 std::abs(y) == ring_ || std::abs(z) == ring_))
                        return true;
            }
        }
        return false;
    }

    /// The cells of the ring in one row: all between its ends (`whole`), or the two ends alone.
    [[gnu::always_inline]] bool visitRow(std::size_t rowStart, double rowSquare, bool whole) {
        if (rowSquare >= best_) return false;
        const int count = bins_.cells_.count[0];
        if (whole) {
            const int from = std::max(-ring_, -home_[0]);
            const int to = std::min(ring_, count - 1 - home_[0]);
            for (int offset = from; offset <= to; ++offset)
                if (visitCell(rowStart, rowSquare, offset)) return true;
            return false;
        }
        if (home_[0] - ring_ >= 0 && home_[0] - ring_ < count)
            if (visitCell(rowStart, rowSquare, -ring_)) return true;
        if (home_[0] + ring_ >= 0 && home_[0] + ring_ < count)
            if (visitCell(rowStart, rowSquare, ring_)) return true;
        return false;
    }

    [[gnu::always_inline]] bool visitCell(std::size_t rowStart, double rowSquare, int offset) {
        if (rowSquare + axisSquare(0, offset) >= best_) return false;
        const auto cell = rowStart + static_cast<std::size_t>(home_[0] + offset);
        const std::uint32_t end = bins_.start_[cell + 1];
        for (std::uint32_t item = bins_.start_[cell]; item != end; ++item)
            if (visitItem(bins_.items_[item])) return true;
        return false;
    }

    [[gnu::always_inline]] bool visitItem(const Item& candidate) {
        float ballSquare = 0;
        for (std::size_t k = 0; k < static_cast<std::size_t>(Dim); ++k)
            ballSquare += (local_[k] - candidate.center[k]) * (local_[k] - candidate.center[k]);
        const float limit = bestLength_ + candidate.radius;
        if (ballSquare > limit * limit) return false;
        // A facet is listed in about four cells: look at it once.
        std::uint32_t& last = asked_[candidate.facet % kAsked];
        if (last == candidate.facet) return false;
        last = candidate.facet;
        Vec<Dim> point;
        const double square =
            squaredDistanceToFacet(bins_.facets_[candidate.facet], x_, best_, point);
        if (!(square < best_)) return false;
        any_ = true;
        if constexpr (kWant == Want::kAny) return true;
        if constexpr (kWant == Want::kAll) found_->push_back({point, std::sqrt(square)});
        if constexpr (kWant == Want::kNearest) {
            best_ = square;
            bestLength_ = static_cast<float>(std::sqrt(square) * (1 + 1e-6));
            found_->point = point;
        }
        return false;
    }

    const FacetBins& bins_;
    const Vec<Dim>& x_;
    double reach_;
    Found* found_;
    typename FacetCells<Dim>::Index home_;     // cell of x; may lie outside of all cells
    Vec<Dim> within_;                          // position in the home cell from its lower corner
    double margin_ = 0;                        // from x to the nearest side of the home cell, mm
    int ring_ = 0, lastRing_ = 0;              // the ring that is visited; the outermost
    std::size_t stride_[3] = {1, 0, 0};        // between cells along each axis
    double best_ = 0;                          // squared distance to beat, mm²
    float bestLength_ = 0;                     // its root, rounded up
    std::array<std::uint32_t, kAsked> asked_;  // facets looked at last
    std::array<float, static_cast<std::size_t>(Dim)> local_;  // x relative to the origin
    bool any_ = false;
};

/// The same question to the tree. Of facets at one distance the first counts, as in cells.
template <int Dim>
template <typename FacetBins<Dim>::Want kWant, class Found>
bool FacetBins<Dim>::searchTree(const Vec<Dim>& x, double reach, Found* found) const {
    if (!(reach > 0)) return false;
    double best = reach * reach;
    bool any = false;
    [[maybe_unused]] std::uint32_t first = 0;
    if constexpr (Dim == 3)
        tree_.visitNear(x, best, [&](std::uint32_t facet) {
            Vec<Dim> point;
            const double square = squaredDistanceToFacet(facets_[facet], x, best, point);
            const bool ties = kWant == Want::kNearest && any && square == best && facet < first;
            if (!(square < best) && !ties) return false;
            any = true;
            if constexpr (kWant == Want::kAny) return true;
            if constexpr (kWant == Want::kAll) found->push_back({point, std::sqrt(square)});
            if constexpr (kWant == Want::kNearest) {
                best = square;
                first = facet;
                found->point = point;
            }
            return false;
        });
    if constexpr (kWant == Want::kNearest)
        if (any) found->distance = std::sqrt(best);
    return any;
}

template <int Dim>
bool FacetBins<Dim>::nearest(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) const {
    if (!tree_.empty()) return searchTree<Want::kNearest>(x, reach, &wall);
    return Search<Want::kNearest, WallPoint<Dim>>(*this, x, reach, &wall).run();
}

template <int Dim>
void FacetBins<Dim>::within(const Vec<Dim>& x, double reach,
                            std::vector<WallPoint<Dim>>& points) const {
    if (!tree_.empty())
        searchTree<Want::kAll>(x, reach, &points);
    else
        Search<Want::kAll, std::vector<WallPoint<Dim>>>(*this, x, reach, &points).run();
}

template <int Dim>
bool FacetBins<Dim>::anyCloser(const Vec<Dim>& x, double reach) const {
    if (!tree_.empty()) return searchTree<Want::kAny, const void>(x, reach, nullptr);
    return Search<Want::kAny, const void>(*this, x, reach, nullptr).run();
}

template bool FacetBins<2>::nearest(const Vec<2>&, double, WallPoint<2>&) const;
template bool FacetBins<3>::nearest(const Vec<3>&, double, WallPoint<3>&) const;
template void FacetBins<2>::within(const Vec<2>&, double, std::vector<WallPoint<2>>&) const;
template void FacetBins<3>::within(const Vec<3>&, double, std::vector<WallPoint<3>>&) const;
template bool FacetBins<2>::anyCloser(const Vec<2>&, double) const;
template bool FacetBins<3>::anyCloser(const Vec<3>&, double) const;

}  // namespace vdbpack
