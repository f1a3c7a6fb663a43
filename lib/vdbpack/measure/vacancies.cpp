#include "vdbpack/measure/vacancies.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace vdbpack {

namespace {

/// IndexRange of a box, each with the same number of sample points: consecutive points are near
/// each other.
template <int Dim>
class SampleBlocks {
public:
    SampleBlocks(const Box<Dim>& bounds, double volume, std::uint64_t samplePoints)
        : lo_(bounds.lo) {
        constexpr double kBlockPoints = 4096;
        const double wanted =
            static_cast<double>(samplePoints) * std::clamp(bounds.volume() / volume, 1.0, 1e4);
        const double edge =
            std::pow(bounds.volume() * std::min(1.0, kBlockPoints / wanted), 1.0 / Dim);
        for (int i = 0; i < Dim; ++i) {
            const double size = bounds.hi[i] - bounds.lo[i];
            auto& n = count_[static_cast<std::size_t>(i)];
            n = static_cast<std::size_t>(std::clamp(std::ceil(size / edge), 1.0, 65536.0));
            size_[i] = size / static_cast<double>(n);
            blocks_ *= n;
        }
        points_ = static_cast<std::uint64_t>(std::ceil(wanted / static_cast<double>(blocks_)));
        spacing_ = std::pow(
            bounds.volume() / (static_cast<double>(blocks_) * static_cast<double>(points_)),
            1.0 / Dim);
    }
    std::size_t blocks() const { return blocks_; }
    std::uint64_t points() const { return points_; }  ///< in each block
    double spacing() const { return spacing_; }       ///< edge of the cube of one point, mm
    double halfDiagonal() const { return 0.5 * length(size_) * (1 + 1e-9); }
    Vec<Dim> cornerOf(std::size_t block) const {
        Vec<Dim> corner;
        for (int i = 0; i < Dim; ++i) {
            const auto n = count_[static_cast<std::size_t>(i)];
            corner[i] = lo_[i] + static_cast<double>(block % n) * size_[i];
            block /= n;
        }
        return corner;
    }
    const Vec<Dim>& size() const { return size_; }  ///< of a block

private:
    Vec<Dim> lo_, size_;
    std::array<std::size_t, static_cast<std::size_t>(Dim)> count_{};
    std::size_t blocks_ = 1;
    std::uint64_t points_ = 0;
    double spacing_ = 0;
};

/// Searches the sample points of a block.
template <int Dim>
class VacancySearch {
public:
    VacancySearch(const CellLevels<Dim>& cells, const SampleBlocks<Dim>& blocks, double radius,
                  double farthest)
        : cells_(cells), blocks_(blocks), radius_(radius), farthest_(farthest) {}

    void searchBlock(std::size_t block, DomainSampler<Dim>& sampler, Vacancies<Dim>& found) const {
        const Vec<Dim> corner = blocks_.cornerOf(block);
        const Vec<Dim> middle = corner + blocks_.size() * 0.5;
        WallPoint<Dim> wall;
        const bool crossed = sampler.nearestWall(middle, blocks_.halfDiagonal(), wall);
        if (!crossed && !sampler.contains(middle)) return;
        Spread<Dim> spread(block);
        for (std::uint64_t k = 0; k < blocks_.points(); ++k) {
            Vec<Dim> x = spread.next();
            for (int i = 0; i < Dim; ++i) x[i] = corner[i] + x[i] * blocks_.size()[i];
            const double enough = std::min(found.largest, radius_);
            if (!isFarFromSpheres(x, enough)) continue;
            if (crossed && !(sampler.signedDistance(x) < 0)) continue;
            if (enough > 0 && sampler.nearestWall(x, enough, wall)) continue;
            // The field shows some narrow gaps outside the wall as inside.
            if (crossed && !sampler.contains(x)) continue;
            add(x, sampler, found);
        }
    }

private:
    bool isFarFromSpheres(const Vec<Dim>& x, double reach) const {
        return cells_.forEachNear(x, reach, [&](std::uint32_t, const Sphere<Dim>& s) {
            const double closest = s.radius + reach;
            return squaredLength(x - s.center) >= closest * closest;
        });
    }

    /// Counts a point that is inside, at least `min(found.largest, radius)` from all.
    void add(const Vec<Dim>& x, DomainSampler<Dim>& sampler, Vacancies<Dim>& found) const {
        if (found.largest >= radius_) {
            ++found.points;
            WallPoint<Dim> wall;
            if (!isFarFromSpheres(x, found.largest)) return;
            if (found.largest > 0 && sampler.nearestWall(x, found.largest, wall)) return;
        }
        const double clearance = clearanceOf(x, found.largest, sampler);
        if (found.largest < radius_ && clearance >= radius_) ++found.points;
        if (clearance > found.largest) {
            found.largest = clearance;
            found.at = x;
        }
    }

    /// Distance to the nearest sphere or wall, by doubling the reach of the search.
    double clearanceOf(const Vec<Dim>& x, double atLeast, DomainSampler<Dim>& sampler) const {
        double reach = std::max({2 * atLeast, radius_ / 8, 1e-6 * blocks_.halfDiagonal()});
        for (;; reach *= 2) {
            double clearance = reach;
            cells_.forEachNear(x, reach, [&](std::uint32_t, const Sphere<Dim>& s) {
                clearance = std::min(clearance, length(x - s.center) - s.radius);
                return true;
            });
            WallPoint<Dim> wall;
            if (sampler.nearestWall(x, clearance, wall)) clearance = wall.distance;
            if (clearance < reach || reach > farthest_) return clearance;
        }
    }

    const CellLevels<Dim>& cells_;
    const SampleBlocks<Dim>& blocks_;
    double radius_, farthest_;
};

}  // namespace

template <int Dim>
Vacancies<Dim> findVacancies(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                             double radius, std::uint64_t samplePoints) {
    if (!(radius > 0) || !std::isfinite(radius))
        throw ParameterError(
            fmt::format("vacancies: radius {} mm is not positive; give one", radius));
    if (samplePoints == 0)
        throw ParameterError("vacancies: 0 sample points find nothing; give some");
    requireUsable(spheres);
    const Box<Dim> bounds = domain.bounds();
    const double volume = domain.volume();
    if (bounds.empty() || !(volume > 0) || !(bounds.volume() > 0)) return {};

    const SampleBlocks<Dim> blocks(bounds, volume, samplePoints);
    const PeriodicCell<Dim> cell = domain.cell();
    const double most = 0.5 * cell.shortest();  // farther away no point is from an image
    const CellLevels<Dim> cells(cell.any() ? withImages(spheres, cell, most).spheres : spheres);
    const VacancySearch<Dim> search(cells, blocks, radius, 4 * length(bounds.size()));
    Samplers<Dim> samplers(domain);
    PerThread<Vacancies<Dim>> found;
    parallelFor(IndexRange(0, blocks.blocks(), 1), [&](const IndexRange& range) {
        for (std::size_t b = range.begin(); b < range.end(); ++b)
            search.searchBlock(b, samplers.local(), found.local());
    });
    Vacancies<Dim> result;
    for (const auto& f : found) {
        result.points += f.points;
        if (std::tie(f.largest, f.at.c) > std::tie(result.largest, result.at.c)) {
            result.largest = f.largest;
            result.at = f.at;
        }
    }
    result.spacing = blocks.spacing();
    return result;
}

template Vacancies<2> findVacancies<2>(const std::vector<Sphere<2>>&, const Domain<2>&, double,
                                       std::uint64_t);
template Vacancies<3> findVacancies<3>(const std::vector<Sphere<3>>&, const Domain<3>&, double,
                                       std::uint64_t);

}  // namespace vdbpack
