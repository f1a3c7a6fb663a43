#include "vdbpack/pack/size_distribution.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <string_view>

namespace vdbpack {

/// A distribution at factor 1: nodes (radius, share below) joined by `cdfOf` between them.
struct SizeDistribution::Shape {
    enum class Kind { uniform, normal, lognormal, discrete, massLinear };
    Kind kind = Kind::uniform;
    std::string spec;
    double lo = 0, hi = 0;  ///< mm
    double center = 0, spread = 0;
    int dim = 3;
    std::vector<double> radius;      ///< discrete: values; massLinear: nodes
    std::vector<double> cumulative;  ///< discrete: share up to and with; massLinear: share below
    std::vector<double> massSlope;   ///< massLinear: mass per mm on each interval
    double massTotal = 1;            ///< massLinear: number integral before normalization
    std::vector<double> quantiles;   ///< tabulated inverse for kinds without a formula
    double mean = 0;
    double ballMoment[4] = {};  ///< E[r^d]

    double cdf(double r, bool below) const;
    double invert(double u) const;
    double bisect(double u, double from, double to) const;
    void finish();
};

namespace {

constexpr std::size_t kQuantileNodes = 1 << 14;
constexpr double kTail = 0.01;

double normalCdf(double z) {
    return 0.5 * std::erfc(-z / std::sqrt(2.0));
}

/// Numbers of spheres per unit of mass between diameters (here radii) a and b for mass spread
/// evenly: the integral of r^-dim.
double inversePower(double a, double b, int dim) {
    return dim == 3 ? 0.5 * (1 / (a * a) - 1 / (b * b)) : 1 / a - 1 / b;
}

std::vector<double> parseNumbers(const std::string& spec, std::string_view text,
                                 std::size_t expected, const char* form) {
    std::vector<double> values;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (at <= end) {
        double value = 0;
        const auto [next, failed] = std::from_chars(at, end, value);
        if (failed != std::errc() || !std::isfinite(value) || (next != end && *next != ',')) break;
        values.push_back(value);
        if (next == end) {
            if (values.size() == expected) return values;
            break;
        }
        at = next + 1;
    }
    throw ParameterError(fmt::format(
        "radius distribution '{}' is malformed; write it as {} (lengths in mm)", spec, form));
}

void requireRange(const std::string& spec, double lo, double hi) {
    if (!(lo > 0) || !(hi >= lo))
        throw ParameterError(
            fmt::format("radius distribution '{}': bounds {} and {} must be positive and in order",
                        spec, lo, hi));
    if (lo < 1e-9 || hi > 1e9)
        throw ParameterError(fmt::format(
            "radius distribution '{}': radii from {} to {} mm are absurd; lengths are in mm", spec,
            lo, hi));
}

/// Two numbers a line, separated by comma, semicolon, tab or blanks; a line of words at the top
/// and lines that start with # are passed over.
std::vector<std::pair<double, double>> readTable(const std::string& path, const char* columns) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        throw IoError(path + ": is a folder; name a file");
    if (std::filesystem::is_character_file(path, ignored) ||
        std::filesystem::is_block_file(path, ignored))
        throw IoError(path + ": is a device; give a file or a pipe");
    std::ifstream file(path);
    // A folder opens, but there is nothing to read in it.
    if (!file || std::filesystem::is_directory(path))
        throw IoError(path + ": cannot be read; check the name and its permissions");
    std::vector<std::pair<double, double>> rows;
    const auto addRow = [&](std::string line, std::size_t number) {
        for (char& ch : line)
            if (ch == ',' || ch == ';' || ch == '\t') ch = ' ';
        const auto first = line.find_first_not_of(' ');
        if (first == std::string::npos || line[first] == '#') return;
        double value[2];
        const char* at = line.data() + first;
        const char* const end = line.data() + line.size();
        bool good = true;
        for (double& v : value) {
            while (at != end && *at == ' ') ++at;
            const auto [next, failed] = std::from_chars(at, end, v);
            good = good && failed == std::errc() && std::isfinite(v);
            at = next;
        }
        if (good) {
            rows.emplace_back(value[0], value[1]);
        } else if (!rows.empty() || number > 1) {
            throw InputError(
                fmt::format("{}: line {}: '{}' is not two numbers; expected columns {}", path,
                            number, line.substr(0, 60), columns));
        }
        if (rows.size() > 1000000)
            throw InputError(path + ": more than a million rows; give a coarser table");
    };
    // Lines end in LF, CR LF or CR.
    std::size_t number = 0;
    for (std::string text; std::getline(file, text);) {
        if (!text.empty() && text.back() == '\r') text.pop_back();
        for (std::size_t begin = 0; begin <= text.size();) {
            const std::size_t end = std::min(text.find('\r', begin), text.size());
            addRow(text.substr(begin, end - begin), ++number);
            begin = end + 1;
        }
    }
    if (rows.empty())
        throw InputError(fmt::format("{}: no rows; expected columns {}", path, columns));
    return rows;
}

}  // namespace

double SizeDistribution::Shape::cdf(double r, bool below) const {
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

double SizeDistribution::Shape::bisect(double u, double from, double to) const {
    for (int i = 0; i < 60 && from < to; ++i) {
        const double middle = 0.5 * (from + to);
        (cdf(middle, false) < u ? from : to) = middle;
    }
    return to;
}

double SizeDistribution::Shape::invert(double u) const {
    if (kind == Kind::uniform) return lo + u * (hi - lo);
    if (kind == Kind::discrete) {
        const auto at = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u);
        return radius[static_cast<std::size_t>(at - cumulative.begin())];
    }
    // The tails are too curved for the table.
    if (u < kTail || u > 1 - kTail) return bisect(u, lo, hi);
    const double x = u * static_cast<double>(kQuantileNodes);
    const auto k = std::min(static_cast<std::size_t>(x), kQuantileNodes - 1);
    const double t = x - static_cast<double>(k);
    return quantiles[k] * (1 - t) + quantiles[k + 1] * t;
}

void SizeDistribution::Shape::finish() {
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
    // Moments by the midpoint rule over shares: 2^16 strata leave an error near 1e-9.
    constexpr int kStrata = 1 << 16;
    for (int d = 0; d <= 3; ++d) {
        double sum = 0;
        for (int i = 0; i < kStrata; ++i) sum += std::pow(invert((i + 0.5) / kStrata), d);
        ballMoment[d] = sum / kStrata;
    }
    mean = ballMoment[1];
}

SizeDistribution SizeDistribution::parse(const std::string& spec, int dim, WeightBy weightBy) {
    auto shape = std::make_shared<Shape>();
    shape->spec = spec;
    shape->dim = dim;
    const auto colon = spec.find(':');
    const std::string kind = spec.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : spec.substr(colon + 1);
    using Kind = Shape::Kind;
    if (kind == "constant") {
        const auto v = parseNumbers(spec, rest, 1, "constant:R");
        requireRange(spec, v[0], v[0]);
        shape->kind = Kind::discrete;
        shape->radius = {v[0]};
        shape->cumulative = {1.0};
    } else if (kind == "uniform") {
        const auto v = parseNumbers(spec, rest, 2, "uniform:A,B");
        requireRange(spec, v[0], v[1]);
        shape->lo = v[0];
        shape->hi = v[1];
        if (v[0] == v[1]) {
            shape->kind = Kind::discrete;
            shape->radius = {v[0]};
            shape->cumulative = {1.0};
        }
    } else if (kind == "normal" || kind == "lognormal") {
        const bool logarithmic = kind == "lognormal";
        const auto v = parseNumbers(
            spec, rest, 4, logarithmic ? "lognormal:MEDIAN,SIGMA,A,B" : "normal:MEAN,SD,A,B");
        requireRange(spec, v[2], v[3]);
        if (!(v[1] > 0) || (logarithmic && !(v[0] > 0)) || v[2] == v[3])
            throw ParameterError(fmt::format(
                "radius distribution '{}': the {} and the range A,B must be positive; for one "
                "radius write constant:R",
                spec, logarithmic ? "median, SIGMA" : "standard deviation"));
        shape->kind = logarithmic ? Kind::lognormal : Kind::normal;
        shape->center = v[0];
        shape->spread = v[1];
        shape->lo = v[2];
        shape->hi = v[3];
        const double a = logarithmic ? std::log(v[2] / v[0]) / v[1] : (v[2] - v[0]) / v[1];
        const double b = logarithmic ? std::log(v[3] / v[0]) / v[1] : (v[3] - v[0]) / v[1];
        if (!(normalCdf(b) - normalCdf(a) > 1e-9))
            throw ParameterError(fmt::format(
                "radius distribution '{}': the range {} to {} holds none of it; widen the range",
                spec, v[2], v[3]));
    } else if (kind == "table" && !rest.empty()) {
        auto rows = readTable(rest, "radius,weight");
        std::sort(rows.begin(), rows.end());
        requireRange(spec, rows.front().first, rows.back().first);
        shape->kind = Kind::discrete;
        double total = 0;
        for (const auto& [r, weight] : rows) {
            if (weight < 0)
                throw InputError(
                    fmt::format("{}: weight {} of radius {} is negative", rest, weight, r));
            if (weight == 0) continue;
            total += weightBy == WeightBy::volume ? weight / std::pow(r, dim) : weight;
            if (!shape->radius.empty() && shape->radius.back() == r) {
                shape->cumulative.back() = total;
            } else {
                shape->radius.push_back(r);
                shape->cumulative.push_back(total);
            }
        }
        if (!(total > 0) || !std::isfinite(total))
            throw InputError(rest + ": the weights have no finite, positive sum");
        for (double& c : shape->cumulative) c /= total;
        shape->cumulative.back() = 1;
    } else if (kind == "psd" && !rest.empty()) {
        auto rows = readTable(rest, "diameter,percent finer by mass");
        std::sort(rows.begin(), rows.end());
        if (rows.size() < 2) throw InputError(rest + ": a grading curve needs two points or more");
        requireRange(spec, rows.front().first, rows.back().first);
        const double range = rows.back().second - rows.front().second;
        shape->kind = Kind::massLinear;
        double number = 0;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            shape->radius.push_back(rows[k].first / 2);
            shape->cumulative.push_back(number);
            if (k + 1 == rows.size()) break;
            const double step = rows[k + 1].second - rows[k].second;
            const double width = (rows[k + 1].first - rows[k].first) / 2;
            if (step < 0 || width <= 0 || rows[k].second < 0 || rows[k + 1].second > 100.0001)
                throw InputError(fmt::format(
                    "{}: percent finer must rise from 0 to 100 with the diameter; it goes from {} "
                    "at {} to {} at {}",
                    rest, rows[k].second, rows[k].first, rows[k + 1].second, rows[k + 1].first));
            shape->massSlope.push_back(step / range / width);
            number += shape->massSlope.back() *
                      inversePower(shape->radius[k], rows[k + 1].first / 2, dim);
        }
        if (!(range > 0) || !(number > 0) || !std::isfinite(number))
            throw InputError(rest + ": percent finer does not rise; nothing can be drawn from it");
        shape->massTotal = number;
        for (double& c : shape->cumulative) c /= number;
        shape->lo = shape->radius.front();
        shape->hi = shape->radius.back();
    } else {
        throw ParameterError(
            fmt::format("radius distribution '{}' is not known; use constant:R, uniform:A,B, "
                        "normal:MEAN,SD,A,B, lognormal:MEDIAN,SIGMA,A,B, table:FILE or psd:FILE",
                        spec));
    }
    if (shape->kind == Kind::discrete) {
        shape->lo = shape->radius.front();
        shape->hi = shape->radius.back();
    }
    shape->finish();
    SizeDistribution result(std::move(shape), 1.0);
    result.spec_ = spec;
    return result;
}

double SizeDistribution::quantile(double u) const {
    const double r = factor_ * shape_->invert(std::clamp(u, 0.0, 1.0));
    auto f = static_cast<float>(r);
    // Rounding must not leave the range that was asked for.
    if (f < min()) f = std::nextafter(f, std::numeric_limits<float>::max());
    if (f > max() && std::nextafter(f, 0.0f) >= min()) f = std::nextafter(f, 0.0f);
    return f;
}

double SizeDistribution::cdf(double r) const {
    // A drawn atom is the float nearest to the tabulated value: count it at either.
    const double slack = shape_->kind == Shape::Kind::discrete ? 1e-6 : 0.0;
    return shape_->cdf(r / factor_ * (1 + slack), false);
}

double SizeDistribution::cdfBelow(double r) const {
    const double slack = shape_->kind == Shape::Kind::discrete ? 1e-6 : 0.0;
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

SizeDistribution SizeDistribution::scaled(double factor) const {
    SizeDistribution result(shape_, factor_ * factor);
    const Shape& s = *shape_;
    const double f = result.factor_;
    const std::string kind = s.spec.substr(0, s.spec.find(':'));
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
        result.spec_ = fmt::format("{} x {:.6g}", s.spec, f);
    return result;
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
