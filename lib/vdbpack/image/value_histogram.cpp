#include "vdbpack/image/value_histogram.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kMostBins = 65536;

/// Rounded to a tenth of the leading digit of a bin, so that its text has few digits.
double rounded(double value, double width) {
    const double step = std::pow(10.0, std::floor(std::log10(width)) - 1);
    double number = value;
    parseReal(fmt::format("{:.10g}", std::round(value / step) * step), number);
    return number;
}

}  // namespace

std::uint64_t ValueHistogram::total() const {
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

double ValueHistogram::shareFrom(double value) const {
    std::uint64_t sum = 0;
    for (std::size_t k = 0; k < counts.size(); ++k)
        if (edge(k) + 0.5 * width >= value) sum += counts[k];
    return static_cast<double>(sum) / static_cast<double>(std::max<std::uint64_t>(total(), 1));
}

ValueHistogram ValueHistogram::coarser(std::size_t bins) const {
    const std::size_t each = (counts.size() + bins - 1) / bins;
    ValueHistogram sums{first, width * static_cast<double>(each), {}};
    sums.counts.resize(each > 0 ? (counts.size() + each - 1) / each : 0);
    for (std::size_t k = 0; k < counts.size(); ++k) sums.counts[k / each] += counts[k];
    return sums;
}

ValueHistogram histogramOf(const Image& image, double from) {
    auto [low, high] = valueRange(image);
    if (!std::isfinite(low) || !std::isfinite(high)) return {};
    const bool isWhole =
        image.isRounded || (image.type != NumberType::f32 && image.type != NumberType::f64);
    const double step = image.isRounded ? 1 : std::fabs(image.slope);
    if (from > low) low = isWhole ? low + std::ceil((from - low) / step) * step : from;
    if (!(high > low)) return {};
    ValueHistogram all;
    all.width = (high - low) / kMostBins;
    if (isWhole) all.width = step * std::ceil(all.width / step);
    all.first = isWhole ? low - 0.5 * step : low;
    all.counts.resize(
        static_cast<std::size_t>(std::min((high - all.first) / all.width + 1, kMostBins)));
    PerThread<std::vector<std::uint64_t>> parts(
        [&] { return std::vector<std::uint64_t>(all.counts.size()); });
    image.visit([&](const auto* numbers) {
        parallelFor(IndexRange(0, image.values(), 65536), [&](const IndexRange& block) {
            auto& counts = parts.local();
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                const double bin = (image.value(numbers[i]) - all.first) / all.width;
                if (bin >= 0) ++counts[std::min(static_cast<std::size_t>(bin), counts.size() - 1)];
            }
        });
    });
    for (const auto& part : parts)
        for (std::size_t k = 0; k < part.size(); ++k) all.counts[k] += part[k];
    const auto empty = std::count(all.counts.begin(), all.counts.end(), std::uint64_t{0});
    if (static_cast<std::size_t>(empty) + 1 >= all.counts.size()) all.counts.clear();
    return all;
}

double otsuThreshold(const ValueHistogram& histogram) {
    const auto& counts = histogram.counts;
    double all = 0, allMoment = 0;
    for (std::size_t k = 0; k < counts.size(); ++k) {
        all += static_cast<double>(counts[k]);
        allMoment += static_cast<double>(counts[k]) * static_cast<double>(k);
    }
    double below = 0, moment = 0, most = -1;
    std::size_t last = 0, next = 0;  // bins on both sides of the threshold
    bool isBest = false;
    for (std::size_t k = 0; k < counts.size(); ++k) {
        if (counts[k] == 0) continue;
        if (std::exchange(isBest, false)) next = k;
        below += static_cast<double>(counts[k]);
        moment += static_cast<double>(counts[k]) * static_cast<double>(k);
        const double apart = allMoment * below - moment * all;
        const double between = below < all ? apart * apart / (below * (all - below)) : -1;
        if (between <= most) continue;
        most = between;
        last = k;
        isBest = true;
    }
    return rounded(0.5 * (histogram.edge(last + 1) + histogram.edge(next)), histogram.width);
}

}  // namespace vdbpack
