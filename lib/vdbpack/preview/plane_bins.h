// Private to previews: what lies at a point of a plane.
#pragma once

#include "vdbpack/core/box.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Boxes of a plane in a lattice of cells, to find those that may hold a point. Immutable.
class PlaneBins {
public:
    PlaneBins() = default;
    explicit PlaneBins(const std::vector<Box<2>>& boxes);

    /// Calls `use(index)` for the boxes near `x`, all that hold it among them, in rising order.
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
    double perCell_ = 0;  ///< cells a mm
    std::int64_t columns_ = 0, rows_ = 0;
    std::vector<std::size_t> first_;  ///< of each cell in `items_`, and the end
    std::vector<std::uint32_t> items_;
};

}  // namespace vdbpack
