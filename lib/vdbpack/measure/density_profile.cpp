#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/sampling.h"
#include "vdbpack/measure/density.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Points by which all spheres near the wall are sampled, together.
constexpr double kProfilePoints = 3e6;

/// What spheres cover of each bin, mm^Dim, with the variance of that.
struct BinSums {
    std::vector<double> covered, variance;

    void add(const BinSums& other) {
        for (std::size_t k = 0; k < other.covered.size(); ++k) {
            covered[k] += other.covered[k];
            variance[k] += other.variance[k];
        }
    }
};

/// Adds one sphere, sampled by `points` points of `ball`. `hits` is zero for each bin, before and
/// after.
template <int Dim>
void addSphere(const Sphere<Dim>& sphere, std::size_t seed, const BallPoints<Dim>& ball,
               std::size_t points, double width, double rough, DomainSampler<Dim>& sampler,
               std::vector<int>& hits, BinSums& sums) {
    const std::size_t count = hits.size();
    std::size_t first = count, last = 0;
    ball.visit(sphere, seed, points, [&](const Vec<Dim>& x) {
        // Where the field takes a hair of a sphere for outside, it is at the wall.
        const double d = -sampler.signedDistance(x);
        if (d < -rough) return;
        const double bin = std::max(0.0, d) / width;
        if (!(bin < static_cast<double>(count))) return;
        const auto b = static_cast<std::size_t>(bin);
        first = std::min(first, b);
        last = std::max(last, b);
        ++hits[b];
    });
    const double whole = Measure<Dim>::ball(sphere.radius), all = static_cast<double>(points);
    for (std::size_t b = first; b <= last && b < count; ++b) {
        const double share = hits[b] / all;
        hits[b] = 0;
        sums.covered[b] += share * whole;
        sums.variance[b] += share * (1 - share) / all * whole * whole;
    }
}

template <int Dim>
BinSums sumsOfBins(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain, double width,
                   std::size_t count, const SphereRows& rows) {
    const double known = domain.fieldDepth();
    // Spheres that may lie in a bin, partly or wholly.
    Samplers<Dim> samplers(domain);
    const double end = static_cast<double>(count) * width;
    const double rough = std::max(domain.facts().voxelSize, 1e-9 * width);
    std::vector<unsigned char> near(spheres.size());
    parallelFor(IndexRange(0, spheres.size(), 512), [&](const IndexRange& block) {
        auto& sampler = samplers.local();
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const double d = -sampler.signedDistance(spheres[i].center);
            near[i] = d >= known * (1 - 1e-6) || d - spheres[i].radius < end;
        }
    });
    const auto crossing = static_cast<double>(
        sumOver(rows.ranks, static_cast<std::uint64_t>(std::count(near.begin(), near.end(), 1))));
    const auto points = static_cast<std::size_t>(
        std::clamp(kProfilePoints / std::max(crossing, 1.0), 16.0, 1000.0));
    const BallPoints<Dim> ball(16384 + points);
    const BinSums own = tbb::parallel_deterministic_reduce(
        IndexRange(0, spheres.size(), 8192), BinSums{},
        [&](const IndexRange& block, BinSums mine) {
            mine.covered.resize(count);
            mine.variance.resize(count);
            auto& sampler = samplers.local();
            std::vector<int> hits(count);
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                if (near[i])
                    addSphere(spheres[i], rows[i], ball, points, width, rough, sampler, hits, mine);
            return mine;
        },
        [&](BinSums a, const BinSums& b) {
            if (a.covered.empty()) return b;
            a.add(b);
            return a;
        });
    BinSums all;
    all.covered.resize(count);
    all.variance.resize(count);
    const auto covered = gathered(rows.ranks, own.covered);
    const auto variance = gathered(rows.ranks, own.variance);
    for (std::size_t r = 0; r < covered.size(); ++r) all.add({covered[r], variance[r]});
    return all;
}

}  // namespace

template <int Dim>
DensityProfile densityProfile(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                              double width, double deepest, const SphereRows& rows) {
    const double known = domain.fieldDepth();
    if (!(width > 0 && deepest >= width) || deepest > known * (1 + 1e-6))
        throw ParameterError(
            fmt::format("profile: bins of {} mm down to {} mm; give a positive width and a depth "
                        "from that to {} mm, the depth of the field",
                        width, deepest, known));
    requireUsable(spheres);
    const auto count = static_cast<std::size_t>(std::floor(deepest / width * (1 + 1e-9)));
    if (count > 100000)
        throw ParameterError(
            fmt::format("profile: {} bins are more than the 100000 that it may have; give wider "
                        "ones than {} mm",
                        count, width));
    const BinSums sum = sumsOfBins(spheres, domain, width, count, rows);
    DensityProfile profile;
    profile.width = width;
    std::vector<double> depths;
    for (std::size_t b = 0; b <= count; ++b)
        depths.push_back(std::min(static_cast<double>(b) * width, known));
    const std::vector<double> deeper = domain.volumesDeeperThan(depths);
    for (std::size_t b = 0; b < count; ++b) {
        const double part = deeper[b] - deeper[b + 1];
        if (!(part > 1e-9 * domain.volume())) break;
        profile.volume.push_back(part);
        profile.fraction.push_back(sum.covered[b] / part);
        profile.error.push_back(std::sqrt(sum.variance[b]) / part);
    }
    return profile;
}

template DensityProfile densityProfile<2>(const std::vector<Sphere<2>>&, const Domain<2>&, double,
                                          double, const SphereRows&);
template DensityProfile densityProfile<3>(const std::vector<Sphere<3>>&, const Domain<3>&, double,
                                          double, const SphereRows&);

}  // namespace vdbpack
