#include "vdbpack/pack/size_distribution.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/pack/size_shape.h"
#include "vdbpack/pack/size_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

std::vector<double> parseNumbers(const std::string& spec, std::string_view text,
                                 std::size_t expected, const char* form) {
    auto values = parseNumberList(text);
    if (!values || values->size() != expected)
        throw ParameterError(fmt::format(
            "radius distribution '{}' is malformed; write it as {} (lengths in mm{})", spec, form,
            values && values->size() > expected ? "; decimals have a point, such as 0.5" : ""));
    return std::move(*values);
}

void requireRange(const std::string& spec, double lo, double hi) {
    if (!(lo > 0) || !(hi >= lo))
        throw ParameterError(fmt::format(
            "radius distribution '{}': {}", spec,
            lo == hi
                ? fmt::format("the radius {} must be positive", lo)
                : fmt::format("bounds {} and {} must be positive, the smaller one first", lo, hi)));
    // Beyond these, absolute tolerances of the kernel are no longer small against the radii.
    if (lo < 1e-7 || hi > 1e5)
        throw ParameterError(fmt::format(
            "radius distribution '{}': radii from {} to {} mm; give 1e-7 to 1e5 mm, for a domain "
            "in proportion: `unit` and `scale` make it larger or smaller",
            spec, lo, hi));
}

SizeShape uniformShape(double a, double b) {
    SizeShape shape;
    shape.lo = a;
    shape.hi = b;
    if (a != b) return shape;
    shape.kind = SizeShape::Kind::discrete;
    shape.radius = {a};
    shape.cumulative = {1.0};
    return shape;
}

/// @param weightBy, dim  what weights count, and the power of the radius that volume goes with.
/// @param fail           throws, with what is wrong with the rows.
template <class Fail>
SizeShape tableShape(std::vector<std::pair<double, double>> rows, WeightBy weightBy, int dim,
                     const Fail& fail) {
    std::sort(rows.begin(), rows.end());
    SizeShape shape;
    shape.kind = SizeShape::Kind::discrete;
    double total = 0;
    for (const auto& [r, weight] : rows) {
        if (weight < 0) fail(fmt::format("weight {} of radius {} is negative", weight, r));
        if (weight == 0) continue;
        total += weightBy == WeightBy::volume ? weight / std::pow(r, dim) : weight;
        if (!shape.radius.empty() && shape.radius.back() == r) {
            shape.cumulative.back() = total;
        } else {
            shape.radius.push_back(r);
            shape.cumulative.push_back(total);
        }
    }
    if (!(total > 0) || !std::isfinite(total)) fail("the weights have no finite, positive sum");
    for (double& c : shape.cumulative) c /= total;
    shape.cumulative.back() = 1;
    shape.lo = shape.radius.front();
    shape.hi = shape.radius.back();
    return shape;
}

/// @param rows  diameter and percent finer by mass.
template <class Fail>
SizeShape sieveShape(std::vector<std::pair<double, double>> rows, int dim, const Fail& fail) {
    std::sort(rows.begin(), rows.end());
    SizeShape shape;
    shape.kind = SizeShape::Kind::massLinear;
    shape.dim = dim;
    constexpr double kMissing = 0.5;  // of the mass, that curves are off by where they are read off
    const double range = rows.back().second - rows.front().second;
    double number = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        shape.radius.push_back(rows[k].first / 2);
        shape.cumulative.push_back(number);
        if (k + 1 == rows.size()) break;
        const double step = rows[k + 1].second - rows[k].second;
        const double width = (rows[k + 1].first - rows[k].first) / 2;
        if (step < 0 || width <= 0 || rows[k].second < 0 || rows[k + 1].second > 100.0001)
            fail(
                fmt::format("percent finer must rise from 0 to 100 with the diameter; it goes from "
                            "{} at {} to {} at {}",
                            rows[k].second, rows[k].first, rows[k + 1].second, rows[k + 1].first));
        shape.massSlope.push_back(step / range / width);
        number +=
            shape.massSlope.back() * inversePower(shape.radius[k], rows[k + 1].first / 2, dim);
    }
    if (!(range > 0) || !(number > 0) || !std::isfinite(number))
        fail("percent finer does not rise; nothing can be drawn from it");
    if (rows.front().second > kMissing)
        fail(
            fmt::format("{} % are finer than the smallest diameter, {}; begin with a row of 0 "
                        "percent finer at the smallest diameter to be packed",
                        rows.front().second, rows.front().first));
    if (rows.back().second < 100 - kMissing)
        fail(
            fmt::format("only {} % are finer than the largest diameter, {}; end with a row of 100 "
                        "percent finer (percent, no share of 1)",
                        rows.back().second, rows.back().first));
    shape.massTotal = number;
    for (double& c : shape.cumulative) c /= number;
    shape.lo = shape.radius.front();
    shape.hi = shape.radius.back();
    return shape;
}

/// Rows of two columns that a caller gave apart.
std::vector<std::pair<double, double>> rowsOf(const std::vector<double>& first,
                                              const std::vector<double>& second,
                                              const char* names) {
    if (first.empty() || first.size() != second.size())
        throw ParameterError(fmt::format("{}: {} and {} values; give as many of each, at least one",
                                         names, first.size(), second.size()));
    std::vector<std::pair<double, double>> rows;
    for (std::size_t i = 0; i < first.size(); ++i) {
        if (!std::isfinite(first[i]) || !std::isfinite(second[i]))
            throw ParameterError(fmt::format("{}: row {} ({}, {}) is not two finite numbers", names,
                                             i, first[i], second[i]));
        rows.emplace_back(first[i], second[i]);
    }
    return rows;
}

void requireRange(const std::string& spec, const std::vector<std::pair<double, double>>& rows) {
    const auto [least, most] = std::minmax_element(rows.begin(), rows.end());
    requireRange(spec, least->first, most->first);
}

}  // namespace

SizeDistribution::SizeDistribution(SizeShape shape, std::string spec)
    : base_(spec), spec_(std::move(spec)) {
    shape.finish();
    shape_ = std::make_shared<const SizeShape>(std::move(shape));
}

SizeDistribution SizeDistribution::constant(double radius) {
    const std::string spec = fmt::format("constant:{}", radius);
    requireRange(spec, radius, radius);
    return {uniformShape(radius, radius), spec};
}

SizeDistribution SizeDistribution::uniform(double a, double b) {
    const std::string spec = fmt::format("uniform:{},{}", a, b);
    requireRange(spec, a, b);
    return {uniformShape(a, b), spec};
}

SizeDistribution SizeDistribution::bell(bool logarithmic, double center, double spread, double a,
                                        double b) {
    const std::string spec =
        fmt::format("{}:{},{},{},{}", logarithmic ? "lognormal" : "normal", center, spread, a, b);
    requireRange(spec, a, b);
    if (!(spread > 0) || !std::isfinite(center) || (logarithmic && !(center > 0)) || a == b)
        throw ParameterError(fmt::format(
            "radius distribution '{}': the {} and the range A,B must be positive; for one "
            "radius write constant:R",
            spec, logarithmic ? "median, SIGMA" : "standard deviation"));
    const double from = logarithmic ? std::log(a / center) / spread : (a - center) / spread;
    const double to = logarithmic ? std::log(b / center) / spread : (b - center) / spread;
    if (!(normalCdf(to) - normalCdf(from) > 1e-9))
        throw ParameterError(fmt::format(
            "radius distribution '{}': the range {} to {} holds none of it; widen the range", spec,
            a, b));
    SizeShape shape;
    shape.kind = logarithmic ? SizeShape::Kind::lognormal : SizeShape::Kind::normal;
    shape.center = center;
    shape.spread = spread;
    shape.lo = a;
    shape.hi = b;
    return {std::move(shape), spec};
}

SizeDistribution SizeDistribution::normal(double mean, double sd, double a, double b) {
    return bell(false, mean, sd, a, b);
}

SizeDistribution SizeDistribution::lognormal(double median, double sigma, double a, double b) {
    return bell(true, median, sigma, a, b);
}

SizeDistribution SizeDistribution::table(const std::vector<double>& radii,
                                         const std::vector<double>& weights, WeightBy weightBy,
                                         int dim) {
    const std::string spec = fmt::format("table of {} radii", radii.size());
    auto rows = rowsOf(radii, weights, "radii and weights");
    requireRange(spec, rows);
    const auto fail = [](const std::string& what) {
        throw ParameterError("radii and weights: " + what);
    };
    return {tableShape(std::move(rows), weightBy, dim, fail), spec};
}

SizeDistribution SizeDistribution::sieve(const std::vector<double>& diameters,
                                         const std::vector<double>& percentFiner, int dim) {
    const std::string spec = fmt::format("grading curve of {} diameters", diameters.size());
    auto rows = rowsOf(diameters, percentFiner, "diameters and percent finer");
    const auto fail = [](const std::string& what) {
        throw ParameterError("diameters and percent finer: " + what);
    };
    if (rows.size() < 2) fail("a grading curve needs two points or more");
    requireRange(spec, rows);
    return {sieveShape(std::move(rows), dim, fail), spec};
}

SizeDistribution SizeDistribution::parse(const std::string& spec, int dim, WeightBy weightBy) {
    const auto colon = spec.find(':');
    const std::string kind = spec.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : spec.substr(colon + 1);
    const auto numbers = [&](std::size_t count, const char* form) {
        return parseNumbers(spec, rest, count, form);
    };
    const auto asWritten = [&](SizeDistribution sizes) {
        sizes.base_ = sizes.spec_ = spec;
        return sizes;
    };
    const auto fail = [&](const std::string& what) { throw InputError(rest + ": " + what); };
    if (kind == "constant") return asWritten(constant(numbers(1, "constant:R")[0]));
    if (kind == "uniform") {
        const auto v = numbers(2, "uniform:A,B");
        return asWritten(uniform(v[0], v[1]));
    }
    if (kind == "normal") {
        const auto v = numbers(4, "normal:MEAN,SD,A,B");
        return asWritten(normal(v[0], v[1], v[2], v[3]));
    }
    if (kind == "lognormal") {
        const auto v = numbers(4, "lognormal:MEDIAN,SIGMA,A,B");
        return asWritten(lognormal(v[0], v[1], v[2], v[3]));
    }
    if (kind == "table" && !rest.empty()) {
        auto rows = readSizeTable(rest, SizeTable::weights);
        requireRange(spec, rows);
        return {tableShape(std::move(rows), weightBy, dim, fail), spec};
    }
    if (kind == "psd" && !rest.empty()) {
        auto rows = readSizeTable(rest, SizeTable::sieve);
        if (rows.size() < 2) fail("a grading curve needs two points or more");
        requireRange(spec, rows);
        return {sieveShape(std::move(rows), dim, fail), spec};
    }
    const bool plain =
        !spec.empty() && spec.find_first_not_of("0123456789.,eE+-") == std::string::npos;
    const std::string meant = !plain ? ""
                              : spec.find(',') == std::string::npos
                                  ? "did you mean constant:" + spec + "? "
                                  : "did you mean uniform:" + spec + "? ";
    throw ParameterError(fmt::format(
        "radius distribution '{}' is not known; {}use constant:R, uniform:A,B, "
        "normal:MEAN,SD,A,B, lognormal:MEDIAN,SIGMA,A,B, table:FILE or psd:FILE{}",
        spec, meant,
        similarWord(kind, {"constant", "uniform", "normal", "lognormal", "table", "psd"})));
}

double SizeDistribution::quantile(double u) const {
    const double r = factor_ * shape_->invert(std::clamp(u, 0.0, 1.0));
    auto f = static_cast<float>(r);
    // Rounding must not leave the requested range.
    if (f < min()) f = std::nextafter(f, std::numeric_limits<float>::max());
    if (f > max() && std::nextafter(f, 0.0f) >= min()) f = std::nextafter(f, 0.0f);
    return f;
}

double SizeDistribution::cdf(double r) const {
    // A radius drawn is the float nearest to the tabulated value: both count.
    const double slack = shape_->kind == SizeShape::Kind::discrete ? 1e-6 : 0.0;
    return shape_->cdf(r / factor_ * (1 + slack), false);
}

double SizeDistribution::cdfBelow(double r) const {
    const double slack = shape_->kind == SizeShape::Kind::discrete ? 1e-6 : 0.0;
    return shape_->cdf(r / factor_ * (1 - slack), true);
}

double SizeDistribution::min() const {
    return shape_->lo * factor_;
}
double SizeDistribution::max() const {
    return shape_->hi * factor_;
}
double SizeDistribution::mean() const {
    return shape_->mean * factor_;
}

double SizeDistribution::meanBall(int dim) const {
    return (dim == 3 ? Measure<3>::ball(1) : Measure<2>::ball(1)) * std::pow(factor_, dim) *
           shape_->ballMoment[dim];
}

const std::string& SizeDistribution::spec() const {
    return spec_;
}

SizeDistribution SizeDistribution::upTo(double most) const {
    constexpr int kRadii = 4096;
    constexpr double kLeastShare = 1e-6;
    const double share = cdf(most);
    if (!(most < max()) || share < kLeastShare) return *this;
    if (shape_->kind == SizeShape::Kind::discrete || shape_->kind == SizeShape::Kind::massLinear) {
        std::vector<double> radii(kRadii);
        for (int i = 0; i < kRadii; ++i) radii[i] = quantile(share * (i + 0.5) / kRadii);
        return table(radii, std::vector<double>(kRadii, 1.0));
    }
    SizeShape part = *shape_;
    part.hi = most / factor_;
    SizeDistribution result(std::move(part), base_);
    return result.scaled(factor_);
}

SizeDistribution SizeDistribution::scaled(double factor) const {
    SizeDistribution result = *this;
    result.factor_ = factor_ * factor;
    const SizeShape& s = *shape_;
    const double f = result.factor_;
    const std::string kind = base_.substr(0, base_.find(':'));
    if (kind == "constant")
        result.spec_ = fmt::format("constant:{:.6g}", s.hi * f);
    else if (kind == "uniform")
        result.spec_ = fmt::format("uniform:{:.6g},{:.6g}", s.lo * f, s.hi * f);
    else if (kind == "normal")
        result.spec_ = fmt::format("normal:{:.6g},{:.6g},{:.6g},{:.6g}", s.center * f, s.spread * f,
                                   s.lo * f, s.hi * f);
    else if (kind == "lognormal")
        result.spec_ = fmt::format("lognormal:{:.6g},{:.6g},{:.6g},{:.6g}", s.center * f, s.spread,
                                   s.lo * f, s.hi * f);
    else
        result.spec_ = fmt::format("{} x {:.6g}", base_, f);
    return result;
}

namespace {

double toSixDigits(double x) {
    if (x == 0) return 0;
    const int digits = 5 - static_cast<int>(std::floor(std::log10(std::fabs(x))));
    const double power = std::pow(10.0, std::abs(digits));
    return digits > 0 ? std::round(x * power) / power : std::round(x / power) * power;
}

}  // namespace

SizeDistribution SizeDistribution::rounded() const {
    const SizeShape& s = *shape_;
    const auto length = [&](double x) { return toSixDigits(x * factor_); };
    const std::string kind = base_.substr(0, base_.find(':'));
    std::optional<SizeDistribution> result;
    if (kind == "constant")
        result = constant(length(s.hi));
    else if (kind == "uniform")
        result = uniform(length(s.lo), length(s.hi));
    else if (kind == "normal")
        result = normal(length(s.center), length(s.spread), length(s.lo), length(s.hi));
    else if (kind == "lognormal")
        result = lognormal(length(s.center), toSixDigits(s.spread), length(s.lo), length(s.hi));
    if (!result) return *this;
    result->base_ = result->spec_ = spec_;
    return *result;
}

VolumeShares::VolumeShares(const SizeDistribution& sizes, int dim) {
    constexpr std::size_t kStrata = 1 << 16;
    volume_.resize(kStrata + 1);
    for (std::size_t k = 0; k < kStrata; ++k) {
        const double u = (static_cast<double>(k) + 0.5) / static_cast<double>(kStrata);
        volume_[k + 1] = volume_[k] + std::pow(sizes.quantile(u), dim);
    }
    for (double& v : volume_) v /= volume_.back();
}

double VolumeShares::operator()(double share) const {
    const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(volume_.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(at), volume_.size() - 2);
    const double t = at - static_cast<double>(k);
    return volume_[k] * (1 - t) + volume_[k + 1] * t;
}

}  // namespace vdbpack
