#include "vdbpack/preview/plane_bins.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {
/// Limit of cells along a side, for a few boxes far apart.
constexpr double kMaxCells = 8192;
}  // namespace

PlaneBins::PlaneBins(const std::vector<Box<2>>& boxes) {
    double area = 0;
    for (const auto& box : boxes) {
        bounds_.add(box.lo);
        bounds_.add(box.hi);
        area += box.volume();
    }
    if (boxes.empty()) return;
    const Vec<2> size = bounds_.size();
    const double side = std::max(size[0], size[1]);
    // Cells about as large as the mean box, so that each has a few boxes.
    const double cell =
        std::max({std::sqrt(area / static_cast<double>(boxes.size())), side / kMaxCells, 1e-300});
    perCell_ = 1 / cell;
    columns_ = static_cast<std::int64_t>(size[0] * perCell_) + 1;
    rows_ = static_cast<std::int64_t>(size[1] * perCell_) + 1;
    const auto cells = [&](const Box<2>& box, const auto& use) {
        const auto at = [&](double x, double low, std::int64_t most) {
            return std::clamp(static_cast<std::int64_t>((x - low) * perCell_), std::int64_t{0},
                              most - 1);
        };
        const std::int64_t i0 = at(box.lo[0], bounds_.lo[0], columns_),
                           i1 = at(box.hi[0], bounds_.lo[0], columns_),
                           j0 = at(box.lo[1], bounds_.lo[1], rows_),
                           j1 = at(box.hi[1], bounds_.lo[1], rows_);
        for (std::int64_t j = j0; j <= j1; ++j)
            for (std::int64_t i = i0; i <= i1; ++i) use(static_cast<std::size_t>(j * columns_ + i));
    };
    first_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
    for (const auto& box : boxes) cells(box, [&](std::size_t at) { ++first_[at + 1]; });
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    items_.resize(first_.back());
    auto next = first_;
    for (std::size_t n = 0; n < boxes.size(); ++n)
        cells(boxes[n],
              [&](std::size_t at) { items_[next[at]++] = static_cast<std::uint32_t>(n); });
}

}  // namespace vdbpack
