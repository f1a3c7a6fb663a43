#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"
#include "vdbpack/voids/orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

constexpr const char* kForms =
    "write constant:V, uniform:A,B or normal:MEAN,SD,A,B in radians, or with the suffix deg "
    "(uniform:-10deg,10deg)";
constexpr double kLargest = 4 * kPi;

double normalCdf(double z) {
    return 0.5 * std::erfc(-z * std::sqrt(0.5));
}

[[noreturn]] void fail(const std::string& spec, const std::string& what) {
    throw ParameterError(fmt::format("angle '{}': {}", spec, what));
}

double parseAngle(const std::string& spec, std::string_view text) {
    text = trimmed(text);
    constexpr std::string_view kDegrees = "deg";
    double factor = 1;
    if (text.size() > kDegrees.size() && text.substr(text.size() - kDegrees.size()) == kDegrees) {
        factor = kPi / 180;
        text.remove_suffix(kDegrees.size());
    }
    double value = 0;
    if (!parseNumber(text, value) || !std::isfinite(value))
        fail(spec, fmt::format("'{}' is not a finite number; {}", text, kForms));
    if (std::fabs(value * factor) > kLargest * (1 + 1e-9))
        fail(spec, fmt::format("{} {} exceeds two full turns; write degrees with the suffix deg",
                               value, factor == 1 ? "rad" : "deg"));
    return value * factor;
}

}  // namespace

AngleDistribution AngleDistribution::parse(const std::string& spec) {
    const auto colon = spec.find(':');
    const std::string_view text(spec);
    const auto kind = colon == std::string::npos ? "constant" : trimmed(text.substr(0, colon));
    std::vector<double> v;
    for (std::size_t at = colon == std::string::npos ? 0 : colon + 1;;) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        v.push_back(parseAngle(spec, text.substr(at, end - at)));
        if (end == text.size()) break;
        at = end + 1;
    }
    const bool normal = kind == "normal";
    if (!(kind == "constant" && v.size() == 1) && !(kind == "uniform" && v.size() == 2) &&
        !(normal && v.size() == 4))
        fail(spec, fmt::format("is malformed; {}", kForms));
    AngleDistribution angle;
    angle.lo_ = normal ? v[2] : v.front();
    angle.hi_ = v.back();
    if (angle.lo_ > angle.hi_)
        fail(spec, fmt::format("bounds {} and {} rad are out of order; write the smaller first",
                               angle.lo_, angle.hi_));
    if (!normal) return angle;
    angle.mean_ = v[0];
    angle.spread_ = v[1];
    if (!(angle.spread_ > 0) || angle.lo_ == angle.hi_)
        fail(spec, fmt::format("SD {} rad and the range from {} to {} must be positive; for one "
                               "angle write constant:V",
                               angle.spread_, angle.lo_, angle.hi_));
    const double share = normalCdf((angle.hi_ - angle.mean_) / angle.spread_) -
                         normalCdf((angle.lo_ - angle.mean_) / angle.spread_);
    if (!(share > 1e-9))
        fail(spec,
             fmt::format(
                 "the range from {} to {} rad has no share of the distribution; widen the range",
                 angle.lo_, angle.hi_));
    return angle;
}

double AngleDistribution::quantile(double u) const {
    if (!(spread_ > 0)) return lo_ + u * (hi_ - lo_);
    const double below = normalCdf((lo_ - mean_) / spread_);
    const double wanted = below + u * (normalCdf((hi_ - mean_) / spread_) - below);
    double from = lo_, to = hi_;
    // 40 halvings of a range below four turns leave 2e-11 rad.
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (from + to);
        (normalCdf((middle - mean_) / spread_) < wanted ? from : to) = middle;
    }
    return 0.5 * (from + to);
}

}  // namespace vdbpack
