// Private to previews: finds boxes at a point of a plane.
#pragma once

#include "vdbpack/core/box.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Boxes in a plane, each in all cells that it meets, to find those at a point. Immutable.
///
/// A grid of its own: core's grid is of spheres by their centers, to find pairs within a distance;
/// here boxes of any size (line segments too) are found at a point by looking at one cell.
class PlaneBins {
public:
    PlaneBins() = default;
    explicit PlaneBins(const std::vector<Box<2>>& boxes);

    /// Calls `use(index)`, in rising order, for boxes near `x`, including all that contain `x`.
    template <class Use>
    void near(const Vec<2>& x, const Use& use) const {
        const double i = (x[0] - bounds_.lo[0]) * perCell_, j = (x[1] - bounds_.lo[1]) * perCell_;
        if (!(i >= 0 && j >= 0 && i < static_cast<double>(columns_) &&
              j < static_cast<double>(rows_)))
            return;
        const auto cell = static_cast<std::size_t>(static_cast<std::int64_t>(j) * columns_ +
                                                   static_cast<std::int64_t>(i));
        for (std::size_t k = first_[cell]; k < first_[cell + 1]; ++k) use(items_[k]);
    }

private:
    Box<2> bounds_;
    double perCell_ = 0;  ///< cells per mm
    std::int64_t columns_ = 0, rows_ = 0;
    std::vector<std::size_t> first_;  ///< start of each cell in `items_`, and the end
    std::vector<std::uint32_t> items_;
};

}  // namespace vdbpack
