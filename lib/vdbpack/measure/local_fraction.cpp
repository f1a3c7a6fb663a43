#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/sampling.h"
#include "vdbpack/measure/density.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace vdbpack {

namespace {

/// Volumes are summed in whole parts of a cell, so that sums do not depend on the order.
constexpr double kPart = 0x1p-40;
/// Points by which a sphere that lies in several cells is shared out.
constexpr int kBallPoints = 32;

/// Cubes (2D: squares) in the middle of a box, as many as fit.
template <int Dim>
class CoarseGrid {
public:
    CoarseGrid(const Box<Dim>& bounds, double edge) : edge_(edge) {
        for (int d = 0; d < Dim; ++d) {
            const double fit = std::max(0.0, std::floor(bounds.size()[d] / edge * (1 + 1e-9)));
            count_[static_cast<std::size_t>(d)] = static_cast<std::size_t>(fit);
            cells_ *= static_cast<std::size_t>(fit);
            corner_[d] = bounds.center()[d] - 0.5 * fit * edge;
        }
    }
    /// 0 where the box is narrower than a cell.
    std::size_t cells() const { return cells_; }
    /// The cell of a point; cells() for a point outside of all.
    std::size_t cellAt(const Vec<Dim>& x) const {
        std::size_t cell = 0;
        for (int d = Dim - 1; d >= 0; --d) {
            const double at = std::floor((x[d] - corner_[d]) / edge_);
            const auto size = count_[static_cast<std::size_t>(d)];
            if (!(at >= 0 && at < static_cast<double>(size))) return cells_;
            cell = cell * size + static_cast<std::size_t>(at);
        }
        return cell;
    }
    Vec<Dim> centerOf(std::size_t cell) const {
        Vec<Dim> x = corner_;
        for (int d = 0; d < Dim; ++d) {
            const auto size = count_[static_cast<std::size_t>(d)];
            x[d] += (static_cast<double>(cell % size) + 0.5) * edge_;
            cell /= size;
        }
        return x;
    }

private:
    double edge_;
    std::array<std::size_t, static_cast<std::size_t>(Dim)> count_{};
    std::size_t cells_ = 1;
    Vec<Dim> corner_;
};

/// What spheres cover of each cell, in `unit`s.
template <int Dim>
std::vector<std::uint64_t> coveredParts(const std::vector<Sphere<Dim>>& spheres,
                                        const CoarseGrid<Dim>& grid, double unit,
                                        const SphereRows& rows) {
    std::vector<std::atomic<std::uint64_t>> covered(grid.cells());
    parallelFor(IndexRange(0, spheres.size(), 512), [&](const IndexRange& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const Sphere<Dim>& s = spheres[i];
            const double ball = Measure<Dim>::ball(s.radius);
            const auto add = [&](std::size_t cell, double volume) {
                if (cell < covered.size())
                    covered[cell].fetch_add(static_cast<std::uint64_t>(std::llround(volume / unit)),
                                            std::memory_order_relaxed);
            };
            Vec<Dim> lo = s.center, hi = s.center;
            for (int d = 0; d < Dim; ++d) lo[d] -= s.radius, hi[d] += s.radius;
            const std::size_t home = grid.cellAt(lo);
            if (home < covered.size() && home == grid.cellAt(hi)) {
                add(home, ball);
                continue;
            }
            Spread<Dim> spread(rows[i]);
            for (int k = 0; k < kBallPoints; ++k)
                add(grid.cellAt(s.center + ballPoint<Dim>(spread.next()) * s.radius),
                    ball / kBallPoints);
        }
    });
    std::vector<std::uint64_t> all(covered.begin(), covered.end());
    if (rows.ranks) rows.ranks->sum(all);
    return all;
}

/// Whether the circumscribed sphere of each cell lies in the domain.
template <int Dim>
std::vector<unsigned char> cellsInside(const CoarseGrid<Dim>& grid, const Domain<Dim>& domain,
                                       double edge) {
    Samplers<Dim> samplers(domain);
    std::vector<unsigned char> inside(grid.cells());
    const double halfDiagonal = 0.5 * edge * std::sqrt(static_cast<double>(Dim));
    parallelFor(IndexRange(0, grid.cells(), 64), [&](const IndexRange& block) {
        auto& sampler = samplers.local();
        for (std::size_t c = block.begin(); c < block.end(); ++c) {
            const Vec<Dim> x = grid.centerOf(c);
            inside[c] = sampler.contains(x) && !sampler.isWallCloser(x, halfDiagonal);
        }
    });
    return inside;
}

}  // namespace

template <int Dim>
std::optional<LocalFraction> localFraction(const std::vector<Sphere<Dim>>& spheres,
                                           const Domain<Dim>& domain, double edge,
                                           const SphereRows& rows) {
    if (!(edge > 0) || !std::isfinite(edge))
        throw ParameterError(
            fmt::format("local fraction: cells of {} mm; give a positive edge", edge));
    requireUsable(spheres);
    const Box<Dim> bounds = domain.bounds();
    double wanted = 1;
    for (int d = 0; d < Dim; ++d) wanted *= std::max(1.0, std::floor(bounds.size()[d] / edge));
    if (!(wanted < 1e8))
        throw ParameterError(
            fmt::format("local fraction: {:.3g} cells are too many; give an edge larger than {} mm",
                        wanted, edge));
    const CoarseGrid<Dim> grid(bounds, edge);
    if (grid.cells() == 0) return std::nullopt;
    const PeriodicCell<Dim> cell = domain.cell();
    const auto covered = coveredParts(cell.any() ? withImages(spheres, cell, 0).spheres : spheres,
                                      grid, kPart * std::pow(edge, Dim), rows);
    const auto inside = cellsInside(grid, domain, edge);
    LocalFraction result;
    result.edge = edge;
    double sum = 0, squares = 0;
    for (std::size_t c = 0; c < grid.cells(); ++c) {
        if (!inside[c]) continue;
        const double f = static_cast<double>(covered[c]) * kPart;
        sum += f;
        squares += f * f;
        ++result.cells;
    }
    if (result.cells == 0) return std::nullopt;
    const auto m = static_cast<double>(result.cells);
    result.mean = sum / m;
    result.sd = std::sqrt(std::max(0.0, squares / m - result.mean * result.mean));
    return result;
}

template std::optional<LocalFraction> localFraction<2>(const std::vector<Sphere<2>>&,
                                                       const Domain<2>&, double, const SphereRows&);
template std::optional<LocalFraction> localFraction<3>(const std::vector<Sphere<3>>&,
                                                       const Domain<3>&, double, const SphereRows&);

}  // namespace vdbpack
