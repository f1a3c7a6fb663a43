#include "vdbpack/view/exposure.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

constexpr double kMostCells = 16e6;
constexpr double kPad = 0.8;  // optical radii
/// Empty cells beyond the spheres on each side, which join the space around them.
constexpr double kMargin = 2;

/// What is near a cell.
enum : std::uint8_t { kFilled = 1, kOpen = 2, kNearOpen = 4, kNearVoid = 8 };

/// Cells around a pack.
class CellBox {
public:
    CellBox(const Box<3>& bounds, double side) {
        const Vec<3> size = bounds.size();
        const auto cells = [&](double s) {
            double product = 1;
            for (int d = 0; d < 3; ++d) product *= size[d] / s + 2 * kMargin + 1;
            return product;
        };
        side_ = side;
        while (cells(side_) > kMostCells) side_ *= 1.1;
        lo_ = bounds.grown(kMargin * side_).lo;
        for (std::size_t d = 0; d < 3; ++d)
            n_[d] = static_cast<std::int64_t>(size[static_cast<int>(d)] / side_ + 2 * kMargin) + 1;
        cells_.assign(static_cast<std::size_t>(n_[0] * n_[1] * n_[2]), 0);
    }
    double side() const { return side_; }

    /// Marks the cells whose middles lie within the ball.
    void fill(const Vec<3>& center, double radius) {
        std::array<std::int64_t, 3> first, last;
        for (std::size_t d = 0; d < 3; ++d) {
            const double at = (center[static_cast<int>(d)] - lo_[static_cast<int>(d)]) / side_;
            const double reach = radius / side_;
            first[d] = std::max<std::int64_t>(0, std::llround(at - reach));
            last[d] = std::min<std::int64_t>(n_[d] - 1, std::llround(at + reach) - 1);
        }
        for (std::int64_t z = first[2]; z <= last[2]; ++z)
            for (std::int64_t y = first[1]; y <= last[1]; ++y)
                for (std::int64_t x = first[0]; x <= last[0]; ++x)
                    if (squaredLength(middle(x, y, z) - center) <= radius * radius)
                        cells_[index(x, y, z)] = kFilled;
    }

    /// Marks the cells that are reached from the corner through cells that are not filled.
    void floodFromOutside() {
        std::vector<std::size_t> reached{0};
        cells_[0] |= kOpen;
        const std::array<std::int64_t, 3> step{1, n_[0], n_[0] * n_[1]};
        while (!reached.empty()) {
            const auto at = static_cast<std::int64_t>(reached.back());
            reached.pop_back();
            const std::array<std::int64_t, 3> x{at % n_[0], at / n_[0] % n_[1], at / step[2]};
            for (std::size_t d = 0; d < 3; ++d)
                for (const std::int64_t way : {-1, 1}) {
                    if (x[d] + way < 0 || x[d] + way >= n_[d]) continue;
                    auto& next = cells_[static_cast<std::size_t>(at + way * step[d])];
                    if ((next & (kFilled | kOpen)) != 0) continue;
                    next |= kOpen;
                    reached.push_back(static_cast<std::size_t>(at + way * step[d]));
                }
        }
    }

    /// Marks the cells within `reach` cells, along each axis, of such that are open or not filled.
    void spread(std::int64_t reach) {
        for (auto& cell : cells_) {
            if ((cell & kOpen) != 0) cell |= kNearOpen;
            if ((cell & kFilled) == 0) cell |= kNearVoid;
        }
        const std::array<std::int64_t, 3> step{1, n_[0], n_[0] * n_[1]};
        for (std::size_t d = 0; d < 3; ++d) {
            const std::size_t a = (d + 1) % 3, b = (d + 2) % 3;
            parallelFor(std::int64_t{0}, n_[b], [&](std::int64_t j) {
                for (std::int64_t i = 0; i < n_[a]; ++i)
                    spreadLine(i * step[a] + j * step[b], step[d], n_[d], reach);
            });
        }
    }

    std::uint8_t at(const Vec<3>& x) const {
        std::array<std::int64_t, 3> c;
        for (std::size_t d = 0; d < 3; ++d)
            c[d] = std::clamp<std::int64_t>(
                static_cast<std::int64_t>((x[static_cast<int>(d)] - lo_[static_cast<int>(d)]) /
                                          side_),
                0, n_[d] - 1);
        return cells_[index(c[0], c[1], c[2])];
    }

private:
    std::size_t index(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>((z * n_[1] + y) * n_[0] + x);
    }
    Vec<3> middle(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return lo_ + Vec<3>{{static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5,
                             static_cast<double>(z) + 0.5}} *
                         side_;
    }
    void spreadLine(std::int64_t from, std::int64_t step, std::int64_t count, std::int64_t reach) {
        for (const std::uint8_t mark : {kNearOpen, kNearVoid}) {
            // Forth and back; the marks made on the way do not count again.
            for (const bool back : {false, true}) {
                std::int64_t last = -reach - 1;
                for (std::int64_t i = 0; i < count; ++i) {
                    auto& cell =
                        cells_[static_cast<std::size_t>(from + step * (back ? count - 1 - i : i))];
                    if ((cell & mark) != 0 && (cell & kMade) == 0)
                        last = i;
                    else if (i - last <= reach)
                        cell = static_cast<std::uint8_t>(cell | mark | kMade);
                }
            }
            for (std::int64_t i = 0; i < count; ++i)
                cells_[static_cast<std::size_t>(from + step * i)] &=
                    static_cast<std::uint8_t>(~kMade);
        }
    }
    static constexpr std::uint8_t kMade = 128;

    Vec<3> lo_;
    double side_ = 1;
    std::array<std::int64_t, 3> n_{};
    std::vector<std::uint8_t> cells_;
};

}  // namespace

double opticalRadius(const std::vector<Sphere<3>>& spheres) {
    double squares = 0, cubes = 0;
    for (const auto& s : spheres) {
        squares += s.radius * s.radius;
        cubes += s.radius * s.radius * s.radius;
    }
    return squares > 0 ? cubes / squares : 0;
}

std::vector<Exposure> exposureOf(const std::vector<Sphere<3>>& spheres) {
    std::vector<Exposure> exposure(spheres.size(), Exposure::outer);
    const double radius = opticalRadius(spheres);
    if (!(radius > 0)) return exposure;
    Box<3> bounds;
    for (const auto& s : spheres)
        for (int d = 0; d < 3; ++d) {
            bounds.lo[d] = std::min(bounds.lo[d], s.center[d] - s.radius);
            bounds.hi[d] = std::max(bounds.hi[d], s.center[d] + s.radius);
        }
    const double pad = kPad * radius;
    CellBox cells(bounds.grown(pad), radius);
    for (const auto& s : spheres) cells.fill(s.center, s.radius + pad);
    cells.floodFromOutside();
    cells.spread(
        static_cast<std::int64_t>(std::ceil((kOpticalDepth * radius + pad) / cells.side())));
    parallelFor(std::size_t{0}, spheres.size(), [&](std::size_t i) {
        const std::uint8_t near = cells.at(spheres[i].center);
        exposure[i] = (near & kNearOpen) != 0   ? Exposure::outer
                      : (near & kNearVoid) != 0 ? Exposure::inner
                                                : Exposure::buried;
    });
    return exposure;
}

}  // namespace vdbpack
