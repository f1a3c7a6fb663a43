#include "vdbpack/voids/thinning.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/count.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdbpack {

namespace {

constexpr std::uint64_t kStream = std::uint64_t{5} << 56;

/// Number, smallest and largest radius of the candidates.
struct RadiusRange {
    double min = std::numeric_limits<double>::infinity(), max = 0;
    std::size_t count = 0;
};

template <int Dim>
RadiusRange rangeOf(const std::vector<Sphere<Dim>>& spheres,
                    const std::vector<std::int32_t>& candidates, double fraction) {
    if (!(fraction > 0 && fraction <= 1))
        throw ParameterError(fmt::format("`deleteFraction` {}: must lie in (0, 1]", fraction));
    RadiusRange range;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (candidates[i]) {
            range.min = std::min(range.min, spheres[i].radius);
            range.max = std::max(range.max, spheres[i].radius);
            ++range.count;
        }
    return range;
}

/// Centers in cubic cells, to find the spheres near a point.
///
/// Unlike other cell grids it visits spheres by cell, then by index, for any radii: the
/// order in which spheres are removed determines which are drawn next.
template <int Dim>
class CenterCells {
public:
    CenterCells(const std::vector<Sphere<Dim>>& spheres, double edge) : edge_(edge) {
        for (const auto& s : spheres) bounds_.add(s.center);
        std::size_t cells = 1;
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            // More cells would mostly be empty.
            const double limit =
                std::ceil(std::pow(static_cast<double>(spheres.size()), 1.0 / Dim)) * 4 + 1;
            size_[at] = static_cast<std::size_t>(
                std::min(limit, std::floor(bounds_.size()[d] / edge_) + 1));
            step_[at] =
                std::max(edge_, bounds_.size()[d] / static_cast<double>(size_[at]) * (1 + 1e-12));
            cells *= size_[at];
        }
        start_.assign(cells + 1, 0);
        std::vector<std::size_t> cell(spheres.size());
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            std::array<std::size_t, 3> at{};
            for (int d = 0; d < Dim; ++d)
                at[static_cast<std::size_t>(d)] = slot(spheres[i].center[d], d);
            ++start_[(cell[i] = number(at)) + 1];
        }
        for (std::size_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
        index_.resize(spheres.size());
        std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
        for (std::size_t i = 0; i < spheres.size(); ++i)
            index_[next[cell[i]]++] = static_cast<std::uint32_t>(i);
    }

    template <class Visit>
    void near(const Vec<Dim>& x, double reach, const Visit& visit) const {
        std::array<std::size_t, 3> lo{}, hi{}, at{};
        for (int d = 0; d < Dim; ++d) {
            lo[static_cast<std::size_t>(d)] = slot(x[d] - reach, d);
            hi[static_cast<std::size_t>(d)] = slot(x[d] + reach, d);
        }
        for (at[0] = lo[0]; at[0] <= hi[0]; ++at[0])
            for (at[1] = lo[1]; at[1] <= hi[1]; ++at[1])
                for (at[2] = lo[2]; at[2] <= hi[2]; ++at[2]) {
                    const std::size_t c = number(at);
                    for (std::size_t k = start_[c]; k < start_[c + 1]; ++k) visit(index_[k]);
                }
    }

private:
    std::size_t slot(double x, int d) const {
        const auto at = static_cast<std::size_t>(d);
        const double cell = std::floor((x - bounds_.lo[d]) / step_[at]);
        return static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(size_[at] - 1)));
    }
    std::size_t number(const std::array<std::size_t, 3>& at) const {
        std::size_t n = 0;
        for (std::size_t d = 0; d < Dim; ++d) n = n * size_[d] + at[d];
        return n;
    }

    double edge_;
    Box<Dim> bounds_;
    std::array<std::size_t, 3> size_{1, 1, 1};
    std::array<double, 3> step_{};
    std::vector<std::size_t> start_;
    std::vector<std::uint32_t> index_;
};

}  // namespace

template <int Dim>
std::vector<std::uint8_t> removeLargest(const std::vector<Sphere<Dim>>& spheres,
                                        const std::vector<std::int32_t>& candidates,
                                        double fraction) {
    const RadiusRange radii = rangeOf(spheres, candidates, fraction);
    const double largest = radii.max - fraction * (radii.max - radii.min);
    std::vector<std::uint8_t> keep(spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i)
        keep[i] = !candidates[i] || spheres[i].radius <= largest;
    return keep;
}

template <int Dim>
std::vector<std::uint8_t> removeAround(const std::vector<Sphere<Dim>>& spheres,
                                       const std::vector<std::int32_t>& candidates, double fraction,
                                       std::uint64_t seed, const PeriodicCell<Dim>& cell) {
    indexable(spheres.size(), Measure<Dim>::kSpheres, "split the pack");
    const RadiusRange radii = rangeOf(spheres, candidates, fraction);
    std::vector<std::uint8_t> keep(spheres.size(), 1);
    if (radii.count == 0) return keep;
    const double least = radii.min / fraction, most = radii.max / fraction;
    const SpheresWithImages<Dim> repeated =
        cell.any() ? withImages(spheres, cell, most) : SpheresWithImages<Dim>{};
    const auto& placed = cell.any() ? repeated.spheres : spheres;
    const CenterCells<Dim> cells(placed, std::max(0.5 * (least + radii.min), radii.max));
    // The remaining candidates, unordered, and the index of each in `left`.
    std::vector<std::uint32_t> left, at(spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (candidates[i]) {
            at[i] = static_cast<std::uint32_t>(left.size());
            left.push_back(static_cast<std::uint32_t>(i));
        }
    const auto remove = [&](std::uint32_t i) {
        keep[i] = 0;
        const std::uint32_t last = left.back();
        left[at[i]] = last;
        at[last] = at[i];
        left.pop_back();
    };
    const double wanted = fraction * static_cast<double>(radii.count);
    RandomStream random(seed, kStream);
    while (!left.empty() && static_cast<double>(radii.count - left.size()) < wanted) {
        const double pick = random.uniform() * static_cast<double>(left.size());
        const Vec<Dim> center = placed[left[static_cast<std::size_t>(pick)]].center;
        const double radius = least + random.uniform() * (most - least);
        cells.near(center, radius + radii.max, [&](std::uint32_t image) {
            const std::uint32_t i = cell.any() ? repeated.source[image] : image;
            const double touching = radius + spheres[i].radius;
            if (candidates[i] && keep[i] &&
                squaredLength(placed[image].center - center) < touching * touching)
                remove(i);
        });
    }
    return keep;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                \
    template std::vector<std::uint8_t> removeLargest(const std::vector<Sphere<Dim>>&,           \
                                                     const std::vector<std::int32_t>&, double); \
    template std::vector<std::uint8_t> removeAround(const std::vector<Sphere<Dim>>&,            \
                                                    const std::vector<std::int32_t>&, double,   \
                                                    std::uint64_t, const PeriodicCell<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
