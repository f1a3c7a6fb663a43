#include "vdbpack/measure/radius_histogram.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdbpack {

namespace {

/// Radii of files are 32-bit floats: one that was meant to be the end of a bin belongs to the bin
/// that begins there.
constexpr double kRounding = 1e-6;
/// Radii that spread less, as a share of the largest, are one size.
constexpr double kOneSize = 1e-4;

}  // namespace

RadiusHistogram radiusHistogram(const std::vector<double>& radii,
                                const std::function<double(double)>& askedBelow,
                                std::pair<double, double> range, int bins, Ranks* ranks) {
    RadiusHistogram result;
    double from = std::numeric_limits<double>::infinity(), to = 0;
    for (const double r : radii) {
        from = std::min(from, r);
        to = std::max(to, r);
    }
    from = minOver(ranks, from);
    to = maxOver(ranks, to);
    if (!(from <= to)) return result;
    if (askedBelow) {
        from = std::min(from, range.first);
        to = std::max(to, range.second);
    }
    if (to - from < kOneSize * to) {
        // In the middle of a range in which it can be seen.
        const double middle = (from + to) / 2;
        from = 0.9 * middle;
        to = 1.1 * middle;
    }
    const auto n = static_cast<std::size_t>(bins);
    result.low = from;
    result.width = (to - from) / bins;
    result.counts.assign(n, 0);
    for (const double r : radii) {
        const double at = (r * (1 + kRounding) - from) / result.width;
        result.counts[static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, bins - 1.0))]++;
    }
    if (ranks) ranks->sum(result.counts);
    if (!askedBelow) return result;
    double before = 0;
    for (std::size_t b = 0; b < n; ++b) {
        const double end = from + static_cast<double>(b + 1) * result.width;
        const double below = b + 1 < n ? askedBelow(end / (1 + kRounding)) : 1;
        result.requested.push_back(below - before);
        before = below;
    }
    return result;
}

}  // namespace vdbpack
