#include "vdbpack/core/error.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

/// The distribution that has its quantiles at equal steps and is linear between them.
class Distribution {
public:
    explicit Distribution(const std::vector<double>& quantiles) : q_(quantiles) {}

    /// Share below `x`, without a step that lies at `x`.
    double below(double x) const {
        const auto at = std::lower_bound(q_.begin(), q_.end(), x);
        return share(static_cast<std::size_t>(at - q_.begin()), x);
    }
    /// Share up to `x`, with such a step.
    double upTo(double x) const {
        const auto at = std::upper_bound(q_.begin(), q_.end(), x);
        const auto next = static_cast<std::size_t>(at - q_.begin());
        if (next > 0 && q_[next - 1] == x) return static_cast<double>(next - 1) / steps();
        return share(next, x);
    }

private:
    double steps() const { return static_cast<double>(q_.size() - 1); }
    /// Between the quantiles `next` - 1, which is less than `x`, and `next`, which is not.
    double share(std::size_t next, double x) const {
        if (next == 0) return 0;
        if (next == q_.size()) return 1;
        const double low = q_[next - 1], high = q_[next];
        return (static_cast<double>(next - 1) + (x - low) / (high - low)) / steps();
    }

    const std::vector<double>& q_;
};

}  // namespace

double LengthStatistics::quantile(int percent) const {
    return quantiles[static_cast<std::size_t>(percent) * (quantiles.size() - 1) / 100];
}

double ksDistance(const LengthStatistics& a, const LengthStatistics& b) {
    if (a.quantiles.size() < 2 || b.quantiles.size() < 2)
        throw ParameterError(
            "Kolmogorov-Smirnov distance: a distribution has no quantiles; give two that "
            "`measureMorphometry` returned");
    const Distribution f(a.quantiles), g(b.quantiles);
    // Both are linear between the quantiles of either, so the largest difference is at one of them.
    double largest = 0;
    for (const auto* quantiles : {&a.quantiles, &b.quantiles})
        for (const double x : *quantiles)
            largest = std::max(
                {largest, std::abs(f.below(x) - g.below(x)), std::abs(f.upTo(x) - g.upTo(x))});
    return largest;
}

}  // namespace vdbpack
