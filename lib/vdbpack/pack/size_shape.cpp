#include "vdbpack/pack/size_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

/// Nodes of the tabulated inverse.
constexpr std::size_t kQuantileNodes = 1 << 14;
/// Shares at either end where the inverse is too curved for the table.
constexpr double kTail = 0.01;

}  // namespace

double normalCdf(double z) {
    return 0.5 * std::erfc(-z / std::sqrt(2.0));
}

double inversePower(double a, double b, int dim) {
    return dim == 3 ? 0.5 * (1 / (a * a) - 1 / (b * b)) : 1 / a - 1 / b;
}

double SizeShape::cdf(double r, bool below) const {
    if (kind == Kind::discrete) {
        const auto at = below ? std::lower_bound(radius.begin(), radius.end(), r)
                              : std::upper_bound(radius.begin(), radius.end(), r);
        return at == radius.begin() ? 0.0
                                    : cumulative[static_cast<std::size_t>(at - radius.begin() - 1)];
    }
    if (r <= lo) return 0;
    if (r >= hi) return 1;
    switch (kind) {
        case Kind::uniform:
            return (r - lo) / (hi - lo);
        case Kind::normal: {
            const double a = normalCdf((lo - center) / spread);
            const double b = normalCdf((hi - center) / spread);
            return (normalCdf((r - center) / spread) - a) / (b - a);
        }
        case Kind::lognormal: {
            const double a = normalCdf(std::log(lo / center) / spread);
            const double b = normalCdf(std::log(hi / center) / spread);
            return (normalCdf(std::log(r / center) / spread) - a) / (b - a);
        }
        case Kind::massLinear: {
            const auto k = static_cast<std::size_t>(
                std::upper_bound(radius.begin(), radius.end(), r) - radius.begin() - 1);
            return cumulative[k] + massSlope[k] * inversePower(radius[k], r, dim) / massTotal;
        }
        case Kind::discrete:
            break;
    }
    return 1;
}

double SizeShape::bisect(double u, double from, double to) const {
    for (int i = 0; i < 60 && from < to; ++i) {
        const double middle = 0.5 * (from + to);
        (cdf(middle, false) < u ? from : to) = middle;
    }
    return to;
}

double SizeShape::invert(double u) const {
    if (kind == Kind::uniform) return lo + u * (hi - lo);
    if (kind == Kind::discrete) {
        const auto at = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u);
        return radius[static_cast<std::size_t>(at - cumulative.begin())];
    }
    if (u < kTail || u > 1 - kTail) return bisect(u, lo, hi);
    const double x = u * static_cast<double>(kQuantileNodes);
    const auto k = std::min(static_cast<std::size_t>(x), kQuantileNodes - 1);
    const double t = x - static_cast<double>(k);
    return quantiles[k] * (1 - t) + quantiles[k + 1] * t;
}

void SizeShape::finish() {
    if (kind != Kind::uniform && kind != Kind::discrete) {
        quantiles.resize(kQuantileNodes + 1);
        double a = lo;
        for (std::size_t k = 0; k <= kQuantileNodes; ++k) {
            const double u = static_cast<double>(k) / static_cast<double>(kQuantileNodes);
            a = bisect(u, a, hi);
            quantiles[k] = a;
        }
        quantiles.front() = lo;
        quantiles.back() = hi;
    }
    // Moments by the midpoint rule over shares: the error of 2^16 strata is near 1e-9.
    constexpr int kStrata = 1 << 16;
    double sums[4] = {};
    for (int i = 0; i < kStrata; ++i) {
        const double r = invert((i + 0.5) / kStrata);
        const double powers[4] = {1, r, r * r, std::pow(r, 3)};
        for (int d = 0; d <= 3; ++d) sums[d] += powers[d];
    }
    for (int d = 0; d <= 3; ++d) ballMoment[d] = sums[d] / kStrata;
    mean = ballMoment[1];
}

}  // namespace vdbpack
