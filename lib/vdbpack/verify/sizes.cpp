#include "vdbpack/core/parallel.h"
#include "vdbpack/verify/verify.h"

#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

template <int Dim>
RadiusStatistics radiusStatistics(const std::vector<Sphere<Dim>>& spheres) {
    RadiusStatistics s;
    if (spheres.empty()) return s;
    const double n = static_cast<double>(spheres.size());
    s.min = s.max = spheres.front().radius;
    double sum = 0;
    for (const auto& sphere : spheres) {
        s.min = std::min(s.min, sphere.radius);
        s.max = std::max(s.max, sphere.radius);
        sum += sphere.radius;
    }
    s.mean = sum / n;
    double squares = 0;
    for (const auto& sphere : spheres) {
        const double d = sphere.radius - s.mean;
        squares += d * d;
    }
    s.sd = std::sqrt(squares / n);
    return s;
}

double ksDistance(std::vector<double> radii, const std::function<double(double)>& cdf,
                  const std::function<double(double)>& cdfBefore, int weightPower) {
    constexpr double kRounding = 1e-6;
    const auto& before = cdfBefore ? cdfBefore : cdf;
    if (!std::is_sorted(radii.begin(), radii.end())) tbb::parallel_sort(radii.begin(), radii.end());
    const std::size_t n = radii.size();
    // Weight of the radii before each, by number without a table.
    std::vector<double> sums;
    if (weightPower > 0) {
        sums.resize(n + 1);
        for (std::size_t k = 0; k < n; ++k) {
            double weight = radii[k];
            for (int p = 1; p < weightPower; ++p) weight *= radii[k];
            sums[k + 1] = sums[k] + weight;
        }
    }
    const auto shareBefore = [&](std::size_t k) {
        return sums.empty() ? static_cast<double>(k) / static_cast<double>(n) : sums[k] / sums[n];
    };
    // The share of radii jumps at each radius and is level between: F is above it by the most
    // just before a jump, below it by the most just after one.
    return tbb::parallel_reduce(
        IndexRange(0, n, 1024), 0.0,
        [&](const IndexRange& block, double largest) {
            for (std::size_t k = block.begin(); k < block.end(); ++k) {
                const double r = radii[k];
                if (k == 0 || radii[k - 1] < r)
                    largest = std::max(largest, before(r * (1 - kRounding)) - shareBefore(k));
                if (k + 1 == n || radii[k + 1] > r)
                    largest = std::max(largest, shareBefore(k + 1) - cdf(r * (1 + kRounding)));
            }
            return largest;
        },
        [](double a, double b) { return std::max(a, b); });
}

template RadiusStatistics radiusStatistics<2>(const std::vector<Sphere<2>>&);
template RadiusStatistics radiusStatistics<3>(const std::vector<Sphere<3>>&);

}  // namespace vdbpack
